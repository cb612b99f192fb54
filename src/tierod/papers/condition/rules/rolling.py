"""Angle and rear wheel speeds from rolling without slip, by both routes of Li, Frey and Gauterin."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.graph.maths import cos
from tierod.papers.condition.rules.parameters import ResidualParameters
from tierod.physics.central_axis import (
    central_speed,
    rear_wheel_share,
    rolling_curvature,
    rolling_road_wheel_angle,
    rolling_sideslip,
)


class Route(NamedTuple):
    """What one way to the road-wheel angle gives.

    Args:
        sideslip: at the centre of gravity [rad]
        left_share, right_share: speed of the rear wheels over that of the centre of gravity [-]
    """

    sideslip: Any
    left_share: Any
    right_share: Any


def steer_of_rolling(yaw_rate: Any, left: Any, right: Any, car: ResidualParameters) -> Any:
    """Mean steer of the front wheels [rad] from yaw rate and rear wheels: eqs (7) and (8)."""
    half = 0.5 * car.track_width
    both = (
        rolling_road_wheel_angle(yaw_rate, left, half, car.wheelbase),
        rolling_road_wheel_angle(yaw_rate, right, -half, car.wheelbase),
    )
    return 0.5 * (both[0] + both[1])


def route(road_wheel_angle: Any, car: ResidualParameters) -> Route:
    """Sideslip angle and shares of the wheels at a steer: eqs (22) to (25)."""
    sideslip = rolling_sideslip(road_wheel_angle, car.rear_distance, car.wheelbase)
    curvature = rolling_curvature(road_wheel_angle, sideslip, car.wheelbase)
    half = 0.5 * car.track_width
    shares = (rear_wheel_share(sideslip, curvature, lever) for lever in (half, -half))
    return Route(sideslip, *shares)


def wheels_of_mean(way: Route, left: Any, right: Any, misprint: bool = False) -> tuple[Any, Any]:
    """Speeds of both rear wheels [m/s] from the mean of their central speeds: eqs (24) to (33).

    Args:
        way: sideslip angle and shares
        left, right: measured wheel speeds [m/s]
        misprint: whether the right wheel is divided by the left one's share, as eq (27) is printed
    """
    centre = 0.5 * (
        central_speed(left, way.left_share) + central_speed(right, way.left_share if misprint else way.right_share)
    )
    return centre * way.left_share, centre * way.right_share


def wheels_of_forward_speed(way: Route, forward_speed: Any) -> tuple[Any, Any]:
    """Speeds of both rear wheels [m/s] from a forward speed of the centre of gravity, as in eqs (35) to (41)."""
    centre = forward_speed / cos(way.sideslip)
    return centre * way.left_share, centre * way.right_share
