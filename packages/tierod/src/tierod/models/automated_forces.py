"""Forces on the small automated car of `automated_vehicle`: tyres, drives, kingpins, tie rods."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, limit, sqrt
from tierod.models.automated_parameters import AutomatedParameters, AutomatedState
from tierod.physics.load_transfer import longitudinal_load_transfer
from tierod.physics.single_track import front_axle_load, yaw_moment
from tierod.physics.tyre import saturating_lateral_force

CRAWL = 0.5
"""Added to the speed in denominators; at this speed rolling resistance has half of its value [m/s]."""
LEAST_ACROSS = 0.3
"""Smallest share of the friction that is left for the lateral force under drive forces [-]."""


class Torques(NamedTuple):
    """Torques of both steering motors at the column and of both drives at their wheels [N*m]."""

    steering_motor_1: Scalar
    steering_motor_2: Scalar
    drive_left: Scalar
    drive_right: Scalar


class Forces(NamedTuple):
    """Forces on the car in a state.

    Args:
        front, rear: lateral forces across the body [N]
        along: longitudinal force of tyres, rolling resistance and air [N]
        drive_difference: drive force on the right less that on the left [N]
        kingpin: torque about both kingpins that the tie rods balance, without model error [N*m]
    """

    front: Scalar
    rear: Scalar
    along: Scalar
    drive_difference: Scalar
    kingpin: Scalar


def direction(x: AutomatedState, p: AutomatedParameters) -> tuple[Scalar, Scalar]:
    """Sine and cosine of the road-wheel angle by polynomials, with an error below 1e-4 up to 0.4 rad."""
    angle = p.steering_ratio * x.column_angle
    square = angle * angle
    return angle * (1.0 - square / 6.0), 1.0 - 0.5 * square * (1.0 - square / 12.0)


def drive_force(torque: Scalar, p: AutomatedParameters) -> Scalar:
    """Longitudinal force [N] of a drive without slip; the wheel radius is the nominal one over the wheel speed scale.

    Args:
        torque: at the wheels [N*m]
    """
    return p.wheel_speed_scale / p.wheel_radius * torque


def _turn_slip(x: AutomatedState, p: AutomatedParameters) -> tuple[Scalar, Scalar]:
    """Turn slips of a front and a rear wheel [1/m]."""
    inverse = 1.0 / (absolute(x.speed) + CRAWL)
    return (x.yaw_rate + p.steering_ratio * x.column_rate) * inverse, x.yaw_rate * inverse


def forces_of(x: AutomatedState, torques: Torques, p: AutomatedParameters) -> Forces:
    """Forces on the car in a state."""
    sine, cosine = direction(x, p)
    left, right = drive_force(torques.drive_left, p), drive_force(torques.drive_right, p)
    drive = left + right
    load = front_axle_load(p.mass, p.front_distance, p.rear_distance)
    other = front_axle_load(p.mass, p.rear_distance, p.front_distance)
    shift = longitudinal_load_transfer(drive, p.centre_height, p.front_distance + p.rear_distance)
    grip = p.tyre_friction * load
    used = limit(drive / grip, -1.0, 1.0)
    left_over = grip * sqrt(1.0 - (1.0 - LEAST_ACROSS * LEAST_ACROSS) * used * used)
    growth = 1.0 + p.stiffness_growth * shift / other
    steered = saturating_lateral_force(x.front_slip, p.front_cornering_stiffness, left_over)
    greatest = p.tyre_friction * p.rear_friction_ratio * other
    rear = saturating_lateral_force(x.rear_slip, p.rear_cornering_stiffness * growth, greatest)
    steered, rear = steered + x.front_force_error, rear + x.rear_force_error
    front_turn, _ = _turn_slip(x, p)
    kingpin = (p.mechanical_trail + p.pneumatic_trail) * steered + p.jacking_torque * sine
    kingpin = kingpin + 2.0 * p.turn_slip_stiffness * front_turn + p.scrub_radius * (left - right)
    resisting = p.rolling_resistance * x.speed / (absolute(x.speed) + CRAWL) + p.drag * x.speed * absolute(x.speed)
    return Forces(
        cosine * steered + sine * drive,
        rear,
        cosine * drive - sine * steered - resisting,
        cosine * (right - left),
        kingpin,
    )


def yaw_acceleration_of(x: AutomatedState, forces: Forces, p: AutomatedParameters) -> Scalar:
    """Yaw acceleration of the body [rad/s**2]."""
    front_turn, rear_turn = _turn_slip(x, p)
    moment = yaw_moment(forces.front, forces.rear, p.front_distance, p.rear_distance)
    moment = moment + 0.5 * p.track_width * forces.drive_difference - p.pneumatic_trail * (forces.front + forces.rear)
    return (moment - 2.0 * p.turn_slip_stiffness * (front_turn + rear_turn)) / p.yaw_inertia


def tie_rod_force_of(x: AutomatedState, forces: Forces, p: AutomatedParameters) -> Scalar:
    """Tie-rod force [N], the sum of both sides by virtual work, positive where it opposes a turn to the left."""
    return p.steering_ratio / p.rack_ratio * forces.kingpin + x.tie_rod_force_error
