"""Outputs of a car's body: inertial sensors, position along the path and over ground, and all signals of the body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import arctan, arctan2, cos, maximum, sin, where
from tierod.physics.gravity import GRAVITY
from tierod.physics.single_track import lateral_acceleration_at
from tierod_lab.ground.parts import Reaction, Road


@dataclass(frozen=True)
class InertialUnit:
    """Mounting position of the inertial unit on the body; typically on the tunnel, below the centre of gravity."""

    forward: Annotated[float, "m"] = 0.2
    left: Annotated[float, "m"] = 0.0
    up: Annotated[float, "m"] = -0.15

    def lateral_acceleration(self, reaction: Reaction) -> Scalar:
        """Specific force across the body, with lever arm, bank and roll angle [m/s**2]."""
        at_place = lateral_acceleration_at(
            reaction.lateral_acceleration, reaction.yaw_acceleration, reaction.yaw_rate, self.forward, self.left
        )
        return at_place - self.up * reaction.roll_acceleration + GRAVITY * reaction.roll_angle

    def longitudinal_acceleration(self, reaction: Reaction) -> Scalar:
        """Specific force along the body, with lever arm and grade [m/s**2]."""
        turning = reaction.yaw_rate * reaction.yaw_rate * self.forward + reaction.yaw_acceleration * self.left
        return reaction.longitudinal_acceleration - turning


INSIDE = 0.2
"""Lower bound of 1 - curvature * offset, since the coordinates along the path are singular at a bend's centre [-]."""


class Path(NamedTuple):
    """Motion along a path; the offset is positive to its left, the heading is over ground."""

    distance: Scalar  # distance of the nearest point of the path, along the path [m]
    lateral_offset: Scalar  # offset of the car from this point [m]
    heading_error: Scalar  # heading of the car relative to the path [rad]
    heading: Scalar  # heading of the car over ground [rad]


START = Path(0.0, 0.0, 0.0, 0.0)


def path_rate(path: Path, reaction: Reaction, curvature: Scalar) -> Path:
    """Rate of change of the motion along a path.

    Args:
        curvature: curvature of the path [1/m]

    Source: Frenet frame; Rajamani, Vehicle Dynamics and Control (2012), section 2.5, without its small angles.
    """
    along, across = cos(path.heading_error), sin(path.heading_error)
    forward = reaction.speed * along - reaction.lateral_speed * across
    distance_rate = forward / maximum(1.0 - curvature * path.lateral_offset, INSIDE)
    sideways = reaction.speed * across + reaction.lateral_speed * along
    return Path(distance_rate, sideways, reaction.yaw_rate - curvature * distance_rate, reaction.yaw_rate)


def moved(position: tuple[Scalar, Scalar], reaction: Reaction, heading: Scalar, step: Scalar) -> tuple[Scalar, Scalar]:
    """Coordinates over ground after a step [m].

    Args:
        position: coordinates before the step, x ahead and y to the left of the initial heading [m]
        heading: heading at the start of the step [rad]
        step: sampling interval [s]

    Computed once per step with the speeds at its start: the accumulated error is at most half a step times the change
    of speed.
    """
    middle = heading + 0.5 * step * reaction.yaw_rate
    along, across = cos(middle), sin(middle)
    return (
        position[0] + step * (reaction.speed * along - reaction.lateral_speed * across),
        position[1] + step * (reaction.speed * across + reaction.lateral_speed * along),
    )


ROLLING = 0.5  # Speed below which the sideslip angle is set to zero [m/s]


class Body(NamedTuple):
    """Signals of body and wheels before sensors, and quantities without a sensor (`truth_`)."""

    yaw_rate: Annotated[Scalar, "rad/s"]
    lateral_acceleration: Annotated[Scalar, "m/s**2"]
    longitudinal_acceleration: Annotated[Scalar, "m/s**2"]
    roll_rate: Annotated[Scalar, "rad/s"]
    vehicle_speed: Annotated[Scalar, "m/s"]
    wheel_speed_front_left: Annotated[Scalar, "m/s"]
    wheel_speed_front_right: Annotated[Scalar, "m/s"]
    wheel_speed_rear_left: Annotated[Scalar, "m/s"]
    wheel_speed_rear_right: Annotated[Scalar, "m/s"]
    truth_speed: Annotated[Scalar, "m/s"]
    truth_lateral_speed: Annotated[Scalar, "m/s"]
    truth_sideslip_angle: Annotated[Scalar, "rad"]
    truth_centre_lateral_acceleration: Annotated[Scalar, "m/s**2"]
    truth_yaw_acceleration: Annotated[Scalar, "rad/s**2"]
    truth_roll_angle: Annotated[Scalar, "rad"]
    truth_front_lateral_force: Annotated[Scalar, "N"]
    truth_rear_lateral_force: Annotated[Scalar, "N"]
    truth_front_slip_angle: Annotated[Scalar, "rad"]
    truth_load_front_left: Annotated[Scalar, "N"]
    truth_load_front_right: Annotated[Scalar, "N"]
    truth_load_rear_left: Annotated[Scalar, "N"]
    truth_load_rear_right: Annotated[Scalar, "N"]
    truth_self_aligning_torque: Annotated[Scalar, "N*m"]
    truth_scrub_torque: Annotated[Scalar, "N*m"]
    truth_kingpin_torque: Annotated[Scalar, "N*m"]
    truth_hand_torque: Annotated[Scalar, "N*m"]
    truth_drive_force: Annotated[Scalar, "N"]
    truth_distance: Annotated[Scalar, "m"]
    truth_lateral_offset: Annotated[Scalar, "m"]
    truth_heading_error: Annotated[Scalar, "rad"]
    truth_heading: Annotated[Scalar, "rad"]
    truth_position_x: Annotated[Scalar, "m"]
    truth_position_y: Annotated[Scalar, "m"]
    truth_bank_angle: Annotated[Scalar, "rad"]
    truth_grade_angle: Annotated[Scalar, "rad"]
    truth_road_friction: Annotated[Scalar, ""]


def vehicle_speed(reaction: Reaction) -> Scalar:
    """Speed on the bus, as the brake control unit sends it: the mean of the rear wheels [m/s]."""
    return 0.5 * (reaction.wheel_speeds.rear_left + reaction.wheel_speeds.rear_right)


def body_signals(
    reaction: Reaction,
    unit: InertialUnit,
    path: Path,
    position: tuple[Scalar, Scalar],
    road: Road,
    hand_torque: Scalar,
    drive_force: Scalar,
) -> Body:
    """Signals of the body at one instant.

    Args:
        position: coordinates over ground [m]
        hand_torque: torque of the driver's hands [N*m]
        drive_force: requested force along the road [N]
    """
    rolling = reaction.speed > ROLLING
    sideslip = arctan2(reaction.lateral_speed, where(rolling, reaction.speed, 1.0))
    return Body(
        reaction.yaw_rate,
        unit.lateral_acceleration(reaction),
        unit.longitudinal_acceleration(reaction),
        reaction.roll_rate,
        vehicle_speed(reaction),
        *reaction.wheel_speeds,
        reaction.speed,
        reaction.lateral_speed,
        where(rolling, sideslip, 0.0),
        reaction.lateral_acceleration,
        reaction.yaw_acceleration,
        reaction.roll_angle,
        reaction.front_lateral_force,
        reaction.rear_lateral_force,
        arctan(reaction.front_slip_angle),
        *reaction.loads,
        reaction.self_aligning_torque,
        reaction.scrub_torque,
        reaction.kingpin_left + reaction.kingpin_right,
        hand_torque,
        drive_force,
        path.distance,
        path.lateral_offset,
        path.heading_error,
        path.heading,
        *position,
        road.bank_angle,
        road.grade_angle,
        0.5 * (road.adhesion_left + road.adhesion_right),
    )
