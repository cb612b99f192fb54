"""Rolling without slip: relations between yaw rate, wheel speeds and steer.

A lever is the distance of a point to the left of the vehicle's centre line: half the track for left wheels, negative
for right ones.
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, arctan, cos, tan, where

_LEAST = 1e-9


def _ratio(numerator: Scalar, denominator: Scalar) -> Scalar:
    """A quotient that stays finite where the denominator vanishes."""
    safe = absolute(denominator) > _LEAST
    return numerator / where(safe, denominator, _LEAST)


def rolling_road_wheel_angle(yaw_rate: Scalar, rear_wheel_speed: Scalar, lever: Scalar, wheelbase: Scalar) -> Scalar:
    """Mean steer of the front wheels [rad] from yaw rate and one rear wheel's speed, for rolling without slip.

    Args:
        yaw_rate: [rad/s]
        rear_wheel_speed: of one rear wheel [m/s]
        lever: of this wheel [m]
        wheelbase: [m]

    Validity: moving vehicle with negligible slip of all wheels; an understeering vehicle needs more steer.
    Source: Li, Frey, Gauterin, eq (7), as atan(r L / (v + r lever)): the printed cotangents are singular at zero steer.
    Each of its lines gives the angle of the single track, not that of the left or right wheel as its symbols suggest.
    """
    return arctan(_ratio(yaw_rate * wheelbase, rear_wheel_speed + yaw_rate * lever))


def rolling_sideslip(road_wheel_angle: Scalar, rear_distance: Scalar, wheelbase: Scalar) -> Scalar:
    """Sideslip angle at the centre of gravity [rad] of a vehicle whose rear axle rolls without slip.

    Args:
        road_wheel_angle: mean steer of the front wheels [rad]
        rear_distance: from the centre of gravity to the rear axle [m]
        wheelbase: [m]

    Source: Li, Frey, Gauterin, eq (22).
    """
    return arctan(rear_distance * tan(road_wheel_angle) / wheelbase)


def rolling_curvature(road_wheel_angle: Scalar, sideslip_angle: Scalar, wheelbase: Scalar) -> Scalar:
    """Curvature of the path of the centre of gravity [1/m] of a vehicle that rolls without slip.

    Args:
        road_wheel_angle: mean steer of the front wheels [rad]
        sideslip_angle: at the centre of gravity, from `rolling_sideslip` [rad]
        wheelbase: [m]

    Source: Li, Frey, Gauterin, eq (23).
    """
    return cos(sideslip_angle) * tan(road_wheel_angle) / wheelbase


def rear_wheel_share(sideslip_angle: Scalar, curvature: Scalar, lever: Scalar) -> Scalar:
    """Speed of a rear wheel over that of the centre of gravity [-].

    Args:
        sideslip_angle: at the centre of gravity [rad]
        curvature: of its path, positive to the left [1/m]
        lever: of the wheel [m]

    Source: Li, Frey, Gauterin, eqs (24) to (33), whose radicand is the square of this. Equation (27) is printed with
    the radicand of the left wheel for the right one.
    """
    return absolute(cos(sideslip_angle) - lever * curvature)


def central_speed(rear_wheel_speed: Scalar, share: Scalar) -> Scalar:
    """Speed of the centre of gravity [m/s] from that of a rear wheel.

    Args:
        rear_wheel_speed: [m/s]
        share: of the wheel, from `rear_wheel_share`; limited to values above zero

    Source: Li, Frey, Gauterin, eqs (24) to (27).
    """
    return _ratio(rear_wheel_speed, share)


def rolling_yaw_rate(road_wheel_angle: Scalar, speed: Scalar, wheelbase: Scalar) -> Scalar:
    """Yaw rate [rad/s] of a vehicle that rolls without slip.

    Args:
        road_wheel_angle: mean steer of the front wheels [rad]
        speed: forward speed of the middle of the rear axle [m/s]
        wheelbase: [m]

    Source: Li, Frey, Gauterin, eq (7) solved for the yaw rate.
    """
    return speed * tan(road_wheel_angle) / wheelbase
