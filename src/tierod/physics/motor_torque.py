"""Torque of a motor beside its target: what the voltage leaves at a speed, and what varies with the rotor's angle."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit, sin


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


def torque_ripple(
    motor_angle: Scalar, motor_torque: Scalar, cogging_torque: Scalar, ripple_share: Scalar, order: Scalar
) -> Scalar:
    """Torque [N*m] that cogging and ripple add at the shaft.

    Args:
        motor_angle: mechanical angle of the rotor [rad]
        motor_torque: mean torque of the currents [N*m]
        cogging_torque: amplitude without current [N*m]
        ripple_share: amplitude per torque of the currents [-]
        order: periods per revolution of the rotor [-]

    One order stands for the strongest; cogging and ripple are taken in phase.
    """
    return (cogging_torque + ripple_share * motor_torque) * sin(order * motor_angle)
