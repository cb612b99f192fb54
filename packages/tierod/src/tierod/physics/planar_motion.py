"""Planar motion of a car: its accelerations, and pure pursuit of a path."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import tan


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
    """Derivative of the forward speed [m/s**2]: `longitudinal_acceleration` solved for the forward rate.

    Args:
        acceleration: longitudinal, of the centre of gravity [m/s**2]
        forward_speed: [m/s]
        sideslip_angle: [rad]
        yaw_rate: [rad/s]
    """
    return acceleration + forward_speed * tan(sideslip_angle) * yaw_rate


def pursuit_curvature(offset_ahead: Scalar, reach: Scalar) -> Scalar:
    """Curvature [1/m] of the arc that meets a straight path at a look-ahead distance.

    Args:
        offset_ahead: lateral offset from the path at that distance if the course stayed as it is, positive to the left
            [m]
        reach: look-ahead distance [m], positive

    Source: pure pursuit; Amidi, Integrated Mobile Robot Control, CMU-RI-TR-90-17 (1990): 2 x / L^2.
    """
    return -2.0 * offset_ahead / (reach * reach)
