"""The torsion bar between steering wheel and pinion, which measures the driver's torque."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number


def torsion_bar_torque(
    wheel_angle: Scalar,
    pinion_angle: Scalar,
    stiffness: Scalar,
    wheel_rate: Scalar = 0.0,
    pinion_rate: Scalar = 0.0,
    damping: Scalar = 0.0,
) -> Scalar:
    """Torque [N*m] of the bar on the pinion, positive towards left; it acts on the wheel with the other sign.

    Args:
        wheel_angle: angle of the steering wheel [rad]
        pinion_angle: angle of the pinion [rad]
        stiffness: of the bar [N*m/rad], 80 to 170 in passenger cars
        wheel_rate: rate of the steering wheel [rad/s]
        pinion_rate: rate of the pinion [rad/s]
        damping: of the bar [N*m*s/rad]

    Validity: below the stops of the bar, about 0.08 rad of twist.
    """
    return stiffness * (wheel_angle - pinion_angle) + damping * (wheel_rate - pinion_rate)


def torsion_bar_twist(driver_torque: Number, stiffness: Scalar) -> Number:
    """Twist [rad] of the bar under a torque, the difference of wheel and pinion angle at rest.

    Args:
        driver_torque: torque in the bar [N*m]
        stiffness: of the bar [N*m/rad]
    """
    return driver_torque / stiffness
