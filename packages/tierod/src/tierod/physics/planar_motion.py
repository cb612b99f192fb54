"""Motion of a rigid body in the plane: velocities of its points, central axis, and transfer of wheel loads."""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, arctan, cos, tan, where


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


def lateral_load_transfer(force: Scalar, roll_centre_height: Scalar, roll_torque: Scalar, track: Scalar) -> Scalar:
    """Load [N] that is transferred from the left to the right wheel of an axle.

    Args:
        force: lateral force of the axle's tyres on the body, to the left [N]
        roll_centre_height: of the axle, above ground [m]
        roll_torque: of the axle's springs and dampers, against a roll to the right [N*m]
        track: [m]

    Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., section 23.1: one part through the links at
    once, the other through the springs as the body rolls.
    """
    return (force * roll_centre_height + roll_torque) / track


def longitudinal_load_transfer(force: Scalar, centre_height: Scalar, wheelbase: Scalar) -> Scalar:
    """Load [N] that is transferred from the front to the rear axle.

    Args:
        force: of all tyres along the road, forward [N]
        centre_height: of the centre of gravity, above ground [m]
        wheelbase: [m]
    """
    return force * centre_height / wheelbase
