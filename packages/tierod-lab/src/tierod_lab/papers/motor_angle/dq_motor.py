"""Permanent-magnet motor in the rotor frame, with the load as an input or a state, and its linear q-axis model."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar
from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import LinearSystem
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.clarke_park import RotorVector
from tierod.physics.pm_motor import (
    back_emf_constant,
    current_rate,
    electromagnetic_torque,
    rotor_acceleration,
    torque_constant,
)

DqMotorParameters = MotorParameters  # Parameters of a motor whose d- and q-axis inductances may differ


class DqMotor:
    """Model of the currents in the rotor frame and the speed, with the load as an input.

    Validity: no saturation; the rotor frame turns with the true electrical angle.
    Source: Reinelt et al., eqs (12) to (14), where theta is the mechanical angle; corrected: the torque constant is
    3/2 c_M with amplitude-invariant vectors, and a salient motor makes torque by (L_sd - L_sq) i_sd i_sq too.
    """

    class State(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]

    class Input(NamedTuple):
        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]
        load_torque: Annotated[float, "N*m"]

    class Output(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]

    Parameters = DqMotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: DqMotorParameters) -> State:
        return DqMotor.State(*_rates(x, u, u.load_torque, p))

    @staticmethod
    def output(x: State, u: Input, p: DqMotorParameters) -> Output:
        return DqMotor.Output(x.current_d, x.current_q)


class LoadedDqMotor:
    """The same model with the load as a constant state, which process noise turns into a random walk.

    Source: as `DqMotor`; the load state is an addition, since a neglected load biases the speed.
    """

    class State(NamedTuple):
        current_d: Annotated[float, "A"]
        current_q: Annotated[float, "A"]
        speed: Annotated[float, "rad/s"]
        load_torque: Annotated[float, "N*m"]

    class Input(NamedTuple):
        voltage_d: Annotated[float, "V"]
        voltage_q: Annotated[float, "V"]

    Output = DqMotor.Output
    Parameters = DqMotorParameters

    @staticmethod
    def derivative(x: State, u: Input, p: DqMotorParameters) -> State:
        return LoadedDqMotor.State(*_rates(x, u, x.load_torque, p), 0.0)

    @staticmethod
    def output(x: State, u: Input, p: DqMotorParameters) -> DqMotor.Output:
        return DqMotor.Output(x.current_d, x.current_q)


def _rates(
    x: DqMotor.State | LoadedDqMotor.State,
    u: DqMotor.Input | LoadedDqMotor.Input,
    load_torque: Scalar,
    p: DqMotorParameters,
) -> tuple[Scalar, Scalar, Scalar]:
    current = RotorVector(x.current_d, x.current_q)
    along, across = p.motor_inductance, p.inductance_across
    currents = current_rate(
        current,
        RotorVector(u.voltage_d, u.voltage_q),
        x.speed,
        resistance=p.motor_resistance,
        inductance_d=along,
        inductance_q=across,
        flux=p.motor_flux,
        pole_pairs=p.motor_pole_pairs,
    )
    torque = electromagnetic_torque(current, p.motor_pole_pairs, p.motor_flux, along, across)
    return (*currents, rotor_acceleration(torque, load_torque, x.speed, p.motor_inertia, p.motor_damping))


READINGS = ("corrected", "printed")
"""Torque constant 3/2 c_M, correct for amplitude-invariant vectors, or c_M as printed."""


def q_axis_motor(p: MotorParameters, reading: str = "corrected") -> LinearSystem:
    """Linear system from the q-axis voltage to the q-axis current.

    Args:
        reading: torque constant, "corrected" or "printed"

    Returns:
        states `current_q`, `speed`; input `voltage_q`; output `current_q`

    Raises:
        ParameterError: another reading

    Validity: no d-axis current, and no load.
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
    """The linear system with a constant load torque as a third state `load_torque`.

    Args:
        motor: result of `q_axis_motor`
        inertia: inertia of the rotor [kg*m**2]
    """
    A = np.zeros((3, 3))
    A[:2, :2], A[1, 2] = motor.A, -1.0 / inertia
    B, C = np.vstack([motor.B, [[0.0]]]), np.hstack([motor.C, [[0.0]]])
    return LinearSystem(A, B, C, motor.D, (*motor.states, "load_torque"), motor.inputs, motor.outputs)


def _system(A: list[list[float]], p: MotorParameters, states: tuple[str, ...]) -> LinearSystem:
    B, C = np.array([[1.0 / p.motor_inductance], [0.0]]), np.array([[1.0, 0.0]])
    return LinearSystem(np.array(A), B, C, np.zeros((1, 1)), states, ("voltage_q",), ("current_q",))
