"""What torque the voltage leaves to a motor at a speed."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit


def driving_limit(speed: Scalar, maximum_torque: Scalar, base_speed: Scalar, no_load_speed: Scalar) -> Scalar:
    """Greatest torque [N*m] in the direction in which the speed counts positive.

    Args:
        speed: of the rotor in the direction of the torque [rad/s]; braking is limited by the current alone
        maximum_torque: what the current limit allows [N*m]
        base_speed: up to which all of it is there [rad/s]
        no_load_speed: at which nothing is left [rad/s], above the base speed

    Validity: a straight line between both speeds, as of a motor without field weakening.
    """
    return maximum_torque * limit((no_load_speed - speed) / (no_load_speed - base_speed), 0.0, 1.0)
