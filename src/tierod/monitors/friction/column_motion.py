"""Motion of the column below an elastic torsion bar, where dry friction acts, from signals taken above it."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.monitors.friction.conditioning import ConditionedSteering
from tierod.physics.steering_ratio import torsion_bar_twist


class ColumnMotion(NamedTuple):
    """What turns below the bar.

    Args:
        angle: [rad]
        increment: since the sample before [rad]
        rate: [rad/s]
        acceleration: [rad/s**2]
    """

    angle: Any
    increment: Any
    rate: Any
    acceleration: Any


def column_motion(clean: ConditionedSteering, stiffness: Any, sample_time: Any) -> ColumnMotion:
    """The steering wheel's motion less the twist of the bar.

    Angle and torque have passed the same low-pass and the same difference, so that the twist is neither early nor late.

    Args:
        clean: signals
        stiffness: of the bar [N*m/rad]; infinite for a rigid one
        sample_time: [s]
    """
    signals = clean.signals
    twist_rate = torsion_bar_twist(clean.driver_torque_rate, stiffness)
    return ColumnMotion(
        signals.steering_wheel_angle - torsion_bar_twist(signals.driver_torque, stiffness),
        clean.angle_increment - sample_time * twist_rate,
        signals.steering_wheel_rate - twist_rate,
        clean.steering_wheel_acceleration - torsion_bar_twist(clean.driver_torque_acceleration, stiffness),
    )
