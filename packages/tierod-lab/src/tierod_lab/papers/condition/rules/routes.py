"""Models of the residuals: rolling without slip by both routes of the paper, and the filter of the single track."""

from __future__ import annotations

from typing import Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, arctan, cos, tan
from tierod.methods.estimators import KalmanFilter
from tierod.models.single_track import SingleTrack
from tierod.physics.motion import _ratio
from tierod_lab.papers.condition.rules.parameters import ResidualParameters
from tierod_lab.papers.condition.rules.rack import discretise_pair


class Route(NamedTuple):
    """Sideslip angle and wheel speed ratios by one route to the road-wheel angle."""

    sideslip: Scalar  # sideslip angle at the centre of gravity [rad]
    left_share: Scalar  # left_share, right_share: speed of the rear wheels over that of the centre of gravity [-]
    right_share: Scalar


def steer_of_rolling(yaw_rate: Scalar, left: Scalar, right: Scalar, car: ResidualParameters) -> Scalar:
    """Mean steer angle of the front wheels [rad] from yaw rate and rear wheel speeds: eqs (7) and (8)."""
    half = 0.5 * car.track_width
    both = (
        rolling_road_wheel_angle(yaw_rate, left, half, car.wheelbase),
        rolling_road_wheel_angle(yaw_rate, right, -half, car.wheelbase),
    )
    return 0.5 * (both[0] + both[1])


def route(road_wheel_angle: Scalar, car: ResidualParameters) -> Route:
    """Sideslip angle and wheel speed ratios at a road-wheel angle: eqs (22) to (25)."""
    sideslip = rolling_sideslip(road_wheel_angle, car.rear_distance, car.wheelbase)
    curvature = rolling_curvature(road_wheel_angle, sideslip, car.wheelbase)
    half = 0.5 * car.track_width
    shares = (rear_wheel_share(sideslip, curvature, lever) for lever in (half, -half))
    return Route(sideslip, *shares)


def wheels_of_mean(way: Route, left: Scalar, right: Scalar, misprint: bool = False) -> tuple[Scalar, Scalar]:
    """Speeds of both rear wheels [m/s] from the mean of their central speeds: eqs (24) to (33).

    Args:
        left, right: measured wheel speeds [m/s]
        misprint: whether the right wheel is divided by the share of the left one, as eq (27) is printed
    """
    centre = 0.5 * (
        central_speed(left, way.left_share) + central_speed(right, way.left_share if misprint else way.right_share)
    )
    return centre * way.left_share, centre * way.right_share


def wheels_of_forward_speed(way: Route, forward_speed: Scalar) -> tuple[Scalar, Scalar]:
    """Speeds of both rear wheels [m/s] from a forward speed of the centre of gravity, as in eqs (35) to (41)."""
    centre = forward_speed / cos(way.sideslip)
    return centre * way.left_share, centre * way.right_share


class PrintedSingleTrack(SingleTrack):
    """The single-track model with the printed lateral acceleration, whose first term is divided by the speed.

    Source: Li, Frey, Gauterin, eq (14), C[1,1] = -(cf + cr) / (m v), where -(cf + cr) / m is right.
    """

    @staticmethod
    def output(x: SingleTrack.State, u: SingleTrack.Input, p: SingleTrack.Parameters) -> SingleTrack.Output:
        right = SingleTrack.output(x, u, p)
        of_sideslip = (p.front_cornering_stiffness + p.rear_cornering_stiffness) / p.mass * x.sideslip_angle
        printed = right.lateral_acceleration + of_sideslip - of_sideslip / u.vehicle_speed
        return right._replace(lateral_acceleration=printed)


def lateral_filter(parameters: SingleTrack.Parameters, sample_time: float, printed: bool = False) -> KalmanFilter:
    """The filter of eqs (13) and (14), discretised exactly: the poles of the printed tyres lie at up to -560 1/s.

    Args:
        sample_time: sampling interval [s]
        printed: whether the lateral acceleration is the printed one

    The model has more weight than the gyroscope, so that the estimated yaw rate does not follow a faulty reading: a
    random walk of 0.1 rad/s in a second against a noise of 0.1 rad/s of every reading. The paper prints no noises.
    """
    model: Any = discretise_pair(PrintedSingleTrack if printed else SingleTrack)
    return KalmanFilter(
        model,
        model.Parameters(parameters, sample_time),
        (0.0, 0.0),
        (0.01, 0.01),
        (0.02**2 * sample_time, 0.1**2 * sample_time),
        (0.1**2, 0.5**2),
    )


def rolling_road_wheel_angle(yaw_rate: Scalar, rear_wheel_speed: Scalar, lever: Scalar, wheelbase: Scalar) -> Scalar:
    """Mean steer of the front wheels [rad] from yaw rate and one rear wheel's speed, for rolling without slip.

    Validity: moving vehicle with negligible slip of all wheels; an understeering vehicle needs more steer.
    Source: Li, Frey, Gauterin, eq (7), as atan(r L / (v + r lever)): the printed cotangents are singular at zero steer.
    Each of its lines gives the angle of the single track, not that of the left or right wheel as its symbols suggest.

    Args:
        yaw_rate: [rad/s]
        rear_wheel_speed: of one rear wheel [m/s]
        lever: of this wheel [m]
        wheelbase: [m]
    """
    return arctan(_ratio(yaw_rate * wheelbase, rear_wheel_speed + yaw_rate * lever))


def rolling_sideslip(road_wheel_angle: Scalar, rear_distance: Scalar, wheelbase: Scalar) -> Scalar:
    """Sideslip angle at the centre of gravity [rad] of a vehicle whose rear axle rolls without slip.

    Source: Li, Frey, Gauterin, eq (22).

    Args:
        road_wheel_angle: mean steer of the front wheels [rad]
        rear_distance: from the centre of gravity to the rear axle [m]
        wheelbase: [m]
    """
    return arctan(rear_distance * tan(road_wheel_angle) / wheelbase)


def rolling_curvature(road_wheel_angle: Scalar, sideslip_angle: Scalar, wheelbase: Scalar) -> Scalar:
    """Curvature of the path of the centre of gravity [1/m] of a vehicle that rolls without slip.

    Source: Li, Frey, Gauterin, eq (23).

    Args:
        road_wheel_angle: mean steer of the front wheels [rad]
        sideslip_angle: at the centre of gravity, from `rolling_sideslip` [rad]
        wheelbase: [m]
    """
    return cos(sideslip_angle) * tan(road_wheel_angle) / wheelbase


def rear_wheel_share(sideslip_angle: Scalar, curvature: Scalar, lever: Scalar) -> Scalar:
    """Speed of a rear wheel over that of the centre of gravity [-].

    Source: Li, Frey, Gauterin, eqs (24) to (33), whose radicand is the square of this. Equation (27) is printed with
    the radicand of the left wheel for the right one.

    Args:
        sideslip_angle: at the centre of gravity [rad]
        curvature: of its path, positive to the left [1/m]
        lever: of the wheel [m]
    """
    return absolute(cos(sideslip_angle) - lever * curvature)


def central_speed(rear_wheel_speed: Scalar, share: Scalar) -> Scalar:
    """Speed of the centre of gravity [m/s] from that of a rear wheel.

    Source: Li, Frey, Gauterin, eqs (24) to (27).

    Args:
        rear_wheel_speed: [m/s]
        share: of the wheel, from `rear_wheel_share`; limited to values above zero
    """
    return _ratio(rear_wheel_speed, share)
