"""Acceleration of a body that moves in a plane."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import cos, sin, tan


def planar_acceleration(
    speed: Scalar, speed_rate: Scalar, sideslip_angle: Scalar, course_rate: Scalar
) -> tuple[Scalar, Scalar]:
    """Longitudinal and lateral acceleration [m/s**2] of the centre of gravity, in axes of the body.

    Args:
        speed: of the centre of gravity along its path [m/s]
        speed_rate: its derivative [m/s**2]
        sideslip_angle: [rad]
        course_rate: yaw rate plus rate of the sideslip angle [rad/s]

    Source: Li, Frey, Gauterin, eq (17), with the terms of a changing speed, which are left out there.
    """
    across = speed * course_rate
    along, side = cos(sideslip_angle), sin(sideslip_angle)
    return speed_rate * along - across * side, speed_rate * side + across * along


def lateral_acceleration_of_turning(forward_speed: Scalar, yaw_rate: Scalar, sideslip_rate: Scalar) -> Scalar:
    """Lateral acceleration [m/s**2] at a steady forward speed.

    Args:
        forward_speed: [m/s]
        yaw_rate, sideslip_rate: [rad/s]

    Source: Li, Frey, Gauterin, eq (18); it neglects the change of speed times the tangent of the sideslip angle.
    """
    return forward_speed * (yaw_rate + sideslip_rate)


def longitudinal_acceleration(
    forward_rate: Scalar, forward_speed: Scalar, sideslip_angle: Scalar, yaw_rate: Scalar
) -> Scalar:
    """Longitudinal acceleration [m/s**2] of the centre of gravity.

    Args:
        forward_rate: derivative of the forward speed [m/s**2]
        forward_speed: [m/s]
        sideslip_angle: [rad]
        yaw_rate: [rad/s]

    Source: Li, Frey, Gauterin, eq (19): a_x = v_x' - v_y r.
    """
    return forward_rate - forward_speed * tan(sideslip_angle) * yaw_rate


def forward_rate(acceleration: Scalar, forward_speed: Scalar, sideslip_angle: Scalar, yaw_rate: Scalar) -> Scalar:
    """Derivative of the forward speed [m/s**2] from a longitudinal acceleration: `longitudinal_acceleration` turned.

    Args:
        acceleration: longitudinal, of the centre of gravity [m/s**2]
        forward_speed: [m/s]
        sideslip_angle: [rad]
        yaw_rate: [rad/s]
    """
    return acceleration + forward_speed * tan(sideslip_angle) * yaw_rate
