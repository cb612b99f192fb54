"""What body and wheels of a car show."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import arctan, arctan2, where
from tierod.proving_ground.cars.imu import InertialUnit
from tierod.proving_ground.cars.path import Path
from tierod.proving_ground.parts import Reaction, Road

ROLLING = 0.5
"""Speed below which there is no sideslip angle [m/s]."""


class Body(NamedTuple):
    """Signals of body and wheels before sensors, and what no sensor sees (`truth_`)."""

    yaw_rate: Annotated[Any, "rad/s"]
    lateral_acceleration: Annotated[Any, "m/s**2"]
    longitudinal_acceleration: Annotated[Any, "m/s**2"]
    roll_rate: Annotated[Any, "rad/s"]
    vehicle_speed: Annotated[Any, "m/s"]
    wheel_speed_front_left: Annotated[Any, "m/s"]
    wheel_speed_front_right: Annotated[Any, "m/s"]
    wheel_speed_rear_left: Annotated[Any, "m/s"]
    wheel_speed_rear_right: Annotated[Any, "m/s"]
    truth_speed: Annotated[Any, "m/s"]
    truth_lateral_speed: Annotated[Any, "m/s"]
    truth_sideslip_angle: Annotated[Any, "rad"]
    truth_centre_lateral_acceleration: Annotated[Any, "m/s**2"]
    truth_yaw_acceleration: Annotated[Any, "rad/s**2"]
    truth_roll_angle: Annotated[Any, "rad"]
    truth_front_lateral_force: Annotated[Any, "N"]
    truth_rear_lateral_force: Annotated[Any, "N"]
    truth_front_slip_angle: Annotated[Any, "rad"]
    truth_load_front_left: Annotated[Any, "N"]
    truth_load_front_right: Annotated[Any, "N"]
    truth_load_rear_left: Annotated[Any, "N"]
    truth_load_rear_right: Annotated[Any, "N"]
    truth_self_aligning_torque: Annotated[Any, "N*m"]
    truth_scrub_torque: Annotated[Any, "N*m"]
    truth_kingpin_torque: Annotated[Any, "N*m"]
    truth_hand_torque: Annotated[Any, "N*m"]
    truth_drive_force: Annotated[Any, "N"]
    truth_distance: Annotated[Any, "m"]
    truth_lateral_offset: Annotated[Any, "m"]
    truth_heading_error: Annotated[Any, "rad"]
    truth_heading: Annotated[Any, "rad"]
    truth_position_x: Annotated[Any, "m"]
    truth_position_y: Annotated[Any, "m"]
    truth_bank_angle: Annotated[Any, "rad"]
    truth_grade_angle: Annotated[Any, "rad"]
    truth_road_friction: Annotated[Any, ""]


def vehicle_speed(reaction: Reaction) -> Any:
    """Speed [m/s] as the control unit of the brakes tells it on the bus: mean of the rear wheels."""
    return 0.5 * (reaction.wheel_speeds.rear_left + reaction.wheel_speeds.rear_right)


def body_signals(
    reaction: Reaction,
    unit: InertialUnit,
    path: Path,
    position: tuple[Any, Any],
    road: Road,
    hand_torque: Any,
    drive_force: Any,
) -> Body:
    """The signals at one instant.

    Args:
        reaction: of the chassis
        unit: inertial sensors
        path: where the car is along its path
        position: over ground [m]
        road: under the car
        hand_torque: of the driver [N*m]
        drive_force: asked for along the road [N]
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
