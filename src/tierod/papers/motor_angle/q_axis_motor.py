"""The motor as a direct-current one: current across the flux and speed, linear."""

from __future__ import annotations

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import LinearSystem
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.pm_motor import back_emf_constant, torque_constant

READINGS = ("corrected", "printed")
"""Whether the torque constant is 3/2 c_M, as amplitude-invariant vectors want it, or c_M as printed."""


def q_axis_motor(p: MotorParameters, reading: str = "corrected") -> LinearSystem:
    """From the voltage across the flux to the current across it.

    Args:
        p: of the motor
        reading: "corrected" or "printed", of the torque constant

    Returns:
        states `current_q`, `speed`; input `voltage_q`; output `current_q`

    Raises:
        ParameterError: another reading

    Validity: no current along the flux, and no load.
    Source: Reinelt et al., eqs (15), (16), (19) and (20), which print c_M where 3/2 c_M belongs in the mechanical row.
    """
    if reading not in READINGS:
        raise ParameterError(f"reading is '{reading}'{nearest(reading, READINGS)}; expected {' or '.join(READINGS)}")
    emf = back_emf_constant(p.motor_pole_pairs, p.motor_flux)
    torque = torque_constant(p.motor_pole_pairs, p.motor_flux) if reading == "corrected" else emf
    electrical = [-p.motor_resistance / p.motor_inductance, -emf / p.motor_inductance]
    mechanical = [torque / p.motor_inertia, -p.motor_damping / p.motor_inertia]
    return _system([electrical, mechanical], p, ("current_q", "speed"))


def with_load(motor: LinearSystem, inertia: float) -> LinearSystem:
    """The same with a load torque that stays, as a third state `load_torque`.

    Args:
        motor: of `q_axis_motor`
        inertia: of the rotor [kg*m**2]
    """
    A = np.zeros((3, 3))
    A[:2, :2], A[1, 2] = motor.A, -1.0 / inertia
    B, C = np.vstack([motor.B, [[0.0]]]), np.hstack([motor.C, [[0.0]]])
    return LinearSystem(A, B, C, motor.D, (*motor.states, "load_torque"), motor.inputs, motor.outputs)


def _system(A: list[list[float]], p: MotorParameters, states: tuple[str, ...]) -> LinearSystem:
    B, C = np.array([[1.0 / p.motor_inductance], [0.0]]), np.array([[1.0, 0.0]])
    return LinearSystem(np.array(A), B, C, np.zeros((1, 1)), states, ("voltage_q",), ("current_q",))
