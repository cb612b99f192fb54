"""Torque of a motor that varies with the angle of its rotor."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import sin


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
