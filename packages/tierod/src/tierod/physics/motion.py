"""Motion of a car in the plane: single track, rolling wheels, load transfer, gravity.

Arguments, unless a function says otherwise: centre_height: of the centre of gravity, above ground [m]; force: of all
tyres along the road, forward [N]; forward: distance of the point ahead of the centre of gravity [m]; forward_rate:
derivative of the forward speed [m/s**2]; forward_speed [m/s]; front_distance: from the centre of gravity to the front
axle [m]; front_force: lateral force of the front axle, across the body [N]; front_stiffness: cornering stiffness of the
front axle [N/rad]; gradient: from `understeer_gradient` [rad*s**2/m]; lateral_acceleration_of_gravity_centre [m/s**2];
lateral_speed: of the centre of gravity, positive to the left [m/s]; left: its distance to the left of the centre of
gravity [m]; mass: of the vehicle [kg]; rear_distance: from the centre of gravity to the rear axle [m]; rear_force:
lateral force of the rear axle [N]; rear_stiffness: cornering stiffness of the rear axle [N/rad]; road_wheel_angle:
steer of the front wheels [rad]; sideslip_angle [rad]; speed: forward speed [m/s]; wheelbase [m]; yaw_acceleration
[rad/s**2]; yaw_inertia: about the vertical axis [kg*m**2]; yaw_rate [rad/s]; yaw_rate, sideslip_rate [rad/s].
"""

from __future__ import annotations

from tierod.core.block import Scalar
from tierod.core.graph.maths import Number, absolute, tan, where

GRAVITY = 9.81  # Gravitational acceleration [m/s**2], rounded as usual in vehicle dynamics


def front_slip_speed(
    lateral_speed: Number, yaw_rate: Number, speed: Number | Scalar, road_wheel_angle: Number, front_distance: Scalar
) -> Number:
    """Lateral speed [m/s] at which the front tyres slip; over the forward speed it is the slip angle (small angles)."""
    return speed * road_wheel_angle - lateral_speed - front_distance * yaw_rate


def rear_slip_speed(lateral_speed: Number, yaw_rate: Number, rear_distance: Scalar) -> Number:
    """Lateral speed [m/s] at which the rear tyres slip."""
    return rear_distance * yaw_rate - lateral_speed


def lateral_acceleration(front_force: Scalar, rear_force: Scalar, mass: Scalar) -> Scalar:
    """Lateral acceleration [m/s**2] of the centre of gravity from the axle forces."""
    return (front_force + rear_force) / mass


def yaw_moment(front_force: Scalar, rear_force: Scalar, front_distance: Scalar, rear_distance: Scalar) -> Scalar:
    """Moment [N*m] of the axle forces about the vertical axis through the centre of gravity."""
    return front_distance * front_force - rear_distance * rear_force


def yaw_acceleration(
    front_force: Scalar, rear_force: Scalar, yaw_inertia: Scalar, front_distance: Scalar, rear_distance: Scalar
) -> Scalar:
    """Yaw acceleration [rad/s**2] from the axle forces. Source: Mohtat et al., eq (3)."""
    return yaw_moment(front_force, rear_force, front_distance, rear_distance) / yaw_inertia


def front_axle_load(mass: Scalar, front_distance: Scalar, rear_distance: Scalar) -> Scalar:
    """Static load [N] of the front axle; swap the distances for the rear one."""
    return mass * GRAVITY * rear_distance / (front_distance + rear_distance)


def understeer_gradient(
    mass: Scalar, front_distance: Scalar, rear_distance: Scalar, front_stiffness: Scalar, rear_stiffness: Scalar
) -> Scalar:
    """Understeer gradient: additional road-wheel angle per lateral acceleration [rad*s**2/m]; positive for understeer.

    Validity: linear tyres. Source: ISO 4138, derived for the linear single track.
    """
    wheelbase = front_distance + rear_distance
    return mass / wheelbase * (rear_distance / front_stiffness - front_distance / rear_stiffness)


def steady_yaw_gain(speed: Number, wheelbase: Scalar, gradient: Scalar) -> Number:
    """Yaw rate per road-wheel angle [1/s] in a steady turn."""
    return speed / (wheelbase + gradient * speed * speed)


def lateral_acceleration_at(
    lateral_acceleration_of_gravity_centre: Scalar,
    yaw_acceleration: Scalar,
    yaw_rate: Scalar,
    forward: Scalar,
    left: Scalar = 0.0,
) -> Scalar:
    """Lateral acceleration [m/s**2] at a point of the body, for a sensor that is not at the centre of gravity.

    Source: rigid body: a_P = a + r' x - r^2 y.
    """
    return lateral_acceleration_of_gravity_centre + yaw_acceleration * forward - yaw_rate * yaw_rate * left


def lateral_acceleration_of_turning(forward_speed: Scalar, yaw_rate: Scalar, sideslip_rate: Scalar) -> Scalar:
    """Lateral acceleration [m/s**2] at a steady forward speed.

    Source: Li, Frey, Gauterin, eq (18); it neglects the change of speed times the tangent of the sideslip angle.
    """
    return forward_speed * (yaw_rate + sideslip_rate)


def longitudinal_acceleration(
    forward_rate: Scalar, forward_speed: Scalar, sideslip_angle: Scalar, yaw_rate: Scalar
) -> Scalar:
    """Longitudinal acceleration [m/s**2] of the centre of gravity.

    Source: Li, Frey, Gauterin, eq (19): a_x = v_x' - v_y r.
    """
    return forward_rate - forward_speed * tan(sideslip_angle) * yaw_rate


_LEAST = 1e-9


def _ratio(numerator: Scalar, denominator: Scalar) -> Scalar:
    """A quotient that stays finite where the denominator vanishes."""
    safe = absolute(denominator) > _LEAST
    return numerator / where(safe, denominator, _LEAST)


def rolling_yaw_rate(road_wheel_angle: Scalar, speed: Scalar, wheelbase: Scalar) -> Scalar:
    """Yaw rate [rad/s] of a vehicle that rolls without slip.

    Source: Li, Frey, Gauterin, eq (7) solved for the yaw rate. Args: road_wheel_angle: mean steer of the front wheels
    [rad]; speed: forward speed of the middle of the rear axle [m/s].
    """
    return speed * tan(road_wheel_angle) / wheelbase


def longitudinal_load_transfer(force: Scalar, centre_height: Scalar, wheelbase: Scalar) -> Scalar:
    """Load [N] that is transferred from the front to the rear axle."""
    return force * centre_height / wheelbase
