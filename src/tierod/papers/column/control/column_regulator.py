"""The regulator behind the position control of a column, and what it weighs."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, linearise, sampled
from tierod.models.two_inertia_column import TwoInertiaColumn, TwoInertiaParameters
from tierod.papers.column.control.lqr import Regulator, lqr, with_delay, with_integral

WEIGHTS: Mapping[str, float] = {"shaft": 300.0, "steering_wheel_angle": 200.0, "shaft_integral": 4.0e4}
"""What an error of shaft [1/rad^2], steering wheel [1/rad^2] and integral [1/(rad s)^2] costs against 1 (N m)^2 of the
motor: three degrees of the shaft as much as 1 N m. That of the wheel damps its swing on the bar. Three times as much on
the shaft leaves two thirds of the error that friction makes, and a tenth less of the distance from instability."""

SMOOTHING = 2e-3
"""Time constant of the low-pass of the feedback [s]: it turns the phase of the gear's swing, at 112 Hz in the paper's
column, so that feedback through an observer that leaves out the gear does not excite it."""


def regulator(
    column: TwoInertiaParameters,
    torsion_bar_stiffness: float,
    sample_time: float,
    weights: Mapping[str, float] | None = None,
    torque_weight: float = 1.0,
    smoothing: float = SMOOTHING,
) -> Regulator:
    """The regulator of a column without gear, with its delay, the low-pass of the feedback and the shaft's integral.

    Args:
        column: as it is believed to be
        torsion_bar_stiffness: between the steering wheel and the shaft that follows [N m/rad]
        sample_time: [s]
        weights: of states and of the `shaft`, as `lqr` takes them; `WEIGHTS` where None
        torque_weight: of the motor's torque, 1/(N m)^2
        smoothing: time constant of the low-pass, 0 for none [s]

    Raises:
        ParameterError: as `lqr`
    """
    system = column_system(column, torsion_bar_stiffness, sample_time)
    whole = with_integral(with_delay(system, kept_share(smoothing, sample_time)), ("shaft",), sample_time)
    return lqr(whole, WEIGHTS if weights is None else weights, [torque_weight])


def kept_share(smoothing: float, sample_time: float) -> float:
    """Share that a low-pass keeps from one sample to the next.

    Args:
        smoothing: its time constant, 0 for none [s]
        sample_time: [s]

    Raises:
        ParameterError: a time below zero
    """
    if not 0.0 <= smoothing < math.inf:
        raise ParameterError(f"smoothing is {smoothing} s; expected a time that is not negative")
    return math.exp(-sample_time / smoothing) if smoothing > 0.0 else 0.0


def column_system(column: TwoInertiaParameters, torsion_bar_stiffness: float, sample_time: float) -> LinearSystem:
    """The column from its motor's torque to the `shaft` that follows, sampled.

    Raises:
        ParameterError: a parameter that is not above zero
    """
    if not torsion_bar_stiffness > 0.0:
        raise ParameterError(f"torsion_bar_stiffness is {torsion_bar_stiffness} N m/rad; expected a number above zero")
    for name in ("steering_wheel_inertia", "motor_inertia", "stiffness", "motor_ratio"):
        if not getattr(column, name) > 0.0:
            raise ParameterError(f"{name} is {getattr(column, name)}; expected a number above zero")
    whole = linearise(TwoInertiaColumn, column, (0.0,) * 4, (0.0,) * 3)
    share = column.stiffness / torsion_bar_stiffness
    row = [[0.0, 0.0, 1.0 - share, share / column.motor_ratio]]
    driven = LinearSystem.of(whole.A, row, whole.B[:, :1])
    return sampled(
        LinearSystem(driven.A, driven.B, driven.C, driven.D, whole.states, ("motor_torque",), ("shaft",)), sample_time
    )
