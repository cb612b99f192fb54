"""Luenberger observers of a motor's speed: full, reduced and as printed, and their exact sampling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import Scalar, Tree, named_tuple, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, present, select, where
from tierod.core.model import Model
from tierod.methods.estimators.pole_placement import place
from tierod.models.linear import LinearSystem, Matrices, as_model, sampled
from tierod.models.stator_frame_motor import MotorParameters
from tierod.physics.clarke_park import RotorVector
from tierod.physics.pm_motor import back_emf_constant

INPUTS = ("voltage_q", "current_q")
"""Inputs of a continuous observer."""


def full_observer(motor: LinearSystem, poles: Sequence[complex]) -> LinearSystem:
    """Luenberger observer as a system from voltage and current to its estimates.

    Args:
        motor: result of `q_axis_motor`, with or without load
        poles: poles of the error [1/s], one per state

    Raises:
        ParameterError: the poles cannot be placed

    Source: Reinelt et al., eqs (21) to (24).
    """
    gain = place(motor, poles)
    A, B = motor.A - gain @ motor.C, np.hstack([motor.B, gain])
    estimated = motor.states[1:]
    return LinearSystem(A, B, np.eye(len(A))[1:], np.zeros((len(estimated), 2)), motor.states, INPUTS, estimated)


def reduced_observer(motor: LinearSystem, poles: Sequence[complex]) -> LinearSystem:
    """Reduced Luenberger observer, which takes the current as measured; its states are x_B = x_2 - K I_q.

    Args:
        motor: result of `q_axis_motor`, with or without load
        poles: poles of the error [1/s], one per state except the current

    Raises:
        ParameterError: the poles cannot be placed

    Source: Reinelt et al., eqs (25) to (33). Corrected in (32): K multiplies c_M/L_sq in the factor of x_B and
    R_s/L_sq in that of I_sq, where z_p is printed, and the voltage counts with -K/L_sq.
    """
    estimated = motor.states[1:]
    A11, A12, A21, A22 = motor.A[:1, :1], motor.A[:1, 1:], motor.A[1:, :1], motor.A[1:, 1:]
    gain = place(LinearSystem.of(A22, A12, states=estimated), poles)
    A = A22 - gain @ A12
    current = A @ gain + A21 - gain @ A11
    voltage = motor.B[1:] - gain @ motor.B[:1]
    D = np.hstack([np.zeros_like(gain), gain])
    return LinearSystem(A, np.hstack([voltage, current]), np.eye(len(estimated)), D, estimated, INPUTS, estimated)


def printed_reduced_observer(p: MotorParameters, motor: LinearSystem, pole: float) -> LinearSystem:
    """Eq (32) exactly as printed, with the gain of the correct observer: unstable for every motor.

    Args:
        p: parameters of the motor
        motor: result of `q_axis_motor` without load
        pole: pole of the correct observer [1/s]

    Source: Reinelt et al., eqs (32) and (33).
    """
    emf, inductance = back_emf_constant(p.motor_pole_pairs, p.motor_flux), p.motor_inductance
    damping = p.motor_damping / p.motor_inertia
    gain = (pole + damping) * inductance / emf
    own = emf / inductance - damping
    current = own * gain + motor.A[1, 0] + p.motor_pole_pairs * p.motor_resistance / inductance
    A, B = np.array([[own]]), np.array([[gain / inductance, current]])
    estimated = motor.states[1:]
    return LinearSystem(A, B, np.eye(1), np.array([[0.0, gain]]), estimated, INPUTS, estimated)


def speed_per_load(observer: LinearSystem, motor: LinearSystem, p: MotorParameters) -> float:
    """Steady-state error of the speed, true less estimated, per unknown load [rad/s per N*m].

    Args:
        observer: result of `full_observer` or `reduced_observer`, for any motor
        motor: the true motor, from `q_axis_motor`
        p: parameters of the true motor

    Source: final value of (24); without load -1/(b + c_M (K_t - J k_2)/(R + L k_1)) for the full observer and 1/(J p)
    for the reduced one.
    """
    steady = np.linalg.solve(motor.A, np.array([[0.0], [1.0 / p.motor_inertia]]))
    fed = np.array([[0.0], [steady[0, 0]]])
    estimate = observer.D @ fed - observer.C @ np.linalg.solve(observer.A, observer.B @ fed)
    return float(steady[1, 0] - estimate[0, 0])


class LinearMemory(NamedTuple):
    """States of the observer, its last speed and load, and the current of the last sample."""

    x: Tree
    estimate: Tree
    current: Scalar


@dataclass(frozen=True)
class LinearSpeed:
    """A linear observer with exact sampling, so that its steady-state errors are those of the continuous observer.

    The voltage is the mean over the sample, the current the mean of the values at its ends.

    Args:
        model, parameters: model and matrices of the sampled observer
        extras: names of its estimates besides the speed
    """

    model: Model
    parameters: Matrices
    extras: tuple[str, ...]

    @classmethod
    def of(cls, observer: LinearSystem, sample_time: float) -> LinearSpeed:
        """Sample a continuous observer.

        Args:
            observer: result of `full_observer` or `reduced_observer`
            sample_time: sampling interval [s]

        Raises:
            ParameterError: the observer is unstable
        """
        fastest = np.linalg.eigvals(observer.A).real.max()
        if not fastest < 0.0:
            raise ParameterError(f"the observer diverges with {fastest:+.3g} 1/s; give poles below zero")
        classes = [_numbers(names) for names in (observer.states, INPUTS, observer.outputs)]
        model, parameters = as_model(sampled(observer, sample_time), *classes)
        return cls(model, parameters, ("motor_load_torque",) if "load_torque" in observer.outputs else ())

    def start(self) -> LinearMemory:
        return LinearMemory(skeleton(self.model.State), skeleton(self.model.Output), 0.0)

    def advance(
        self, before: LinearMemory, voltage: RotorVector, current: RotorVector
    ) -> tuple[LinearMemory, tuple[Scalar, ...]]:
        whole = both(present(voltage.q), present(current.q))
        mean = self.model.Input(voltage.q, 0.5 * (before.current + current.q))
        x = self.model.transition(before.x, mean, self.parameters)
        estimate = self.model.output(x, self.model.Input(voltage.q, current.q), self.parameters)
        kept = where(present(current.q), current.q, before.current)
        after = LinearMemory(select(whole, x, before.x), select(whole, estimate, before.estimate), kept)
        return after, tuple(after.estimate)


@lru_cache(maxsize=32)
def _numbers(names: tuple[str, ...]) -> type:
    return named_tuple("Numbers", [(name, Annotated[float, ""]) for name in names])
