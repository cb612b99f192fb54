"""Deviations of a motor's torque from its target: the voltage limit at high speed, and ripple over the rotor angle."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import limit, sin


def driving_limit(speed: Scalar, maximum_torque: Scalar, base_speed: Scalar, no_load_speed: Scalar) -> Scalar:
    """Largest torque [N*m] of the motor in the direction of positive speed.

    Args:
        speed: of the rotor in the direction of the torque [rad/s]; braking is limited by the current alone
        maximum_torque: torque at the current limit [N*m]
        base_speed: speed up to which the maximum torque is available [rad/s]
        no_load_speed: speed at which no torque is left [rad/s], above the base speed

    Validity: linear between both speeds, as for a motor without field weakening.
    """
    return maximum_torque * limit((no_load_speed - speed) / (no_load_speed - base_speed), 0.0, 1.0)


def torque_ripple(
    motor_angle: Scalar, motor_torque: Scalar, cogging_torque: Scalar, ripple_share: Scalar, order: Scalar
) -> Scalar:
    """Torque [N*m] of cogging and current-dependent ripple at the shaft.

    Args:
        motor_angle: mechanical angle of the rotor [rad]
        motor_torque: mean torque of the currents [N*m]
        cogging_torque: amplitude without current [N*m]
        ripple_share: amplitude per torque of the currents [-]
        order: periods per revolution of the rotor [-]

    Only the strongest order is modelled; cogging and ripple are assumed to be in phase.
    """
    return (cogging_torque + ripple_share * motor_torque) * sin(order * motor_angle)
