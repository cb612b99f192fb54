"""What the combined sideslip estimator reads and gives out."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple


class CombinedSample(NamedTuple):
    """One sample, NaN where the car lacks a signal.

    Args:
        vehicle_speed: forward; without it, and below walking pace, the last estimate is held
        road_wheel_angle: mean of both front wheels
        yaw_rate, lateral_acceleration, longitudinal_acceleration: of the inertial unit
        road_wheel_torque: of the actuator about the kingpins, for a car steered by wire
    """

    vehicle_speed: Annotated[Any, "m/s"]
    road_wheel_angle: Annotated[Any, "rad"]
    yaw_rate: Annotated[Any, "rad/s"]
    lateral_acceleration: Annotated[Any, "m/s**2"]
    longitudinal_acceleration: Annotated[Any, "m/s**2"]
    road_wheel_torque: Annotated[Any, "N*m"]


class CombinedEstimate(NamedTuple):
    """What is known after a sample; a `_deviation` is one standard deviation, `identified` the share of the prior
    variance that the data took away.

    Args:
        sideslip_angle: at the centre of gravity
        lateral_speed, corrected_yaw_rate: of the centre of gravity, without the gyroscope's bias
        front_slip_angle, rear_slip_angle: of the axles, positive where the force is to the left
        front_lateral_force, rear_lateral_force: of the axles, across the wheels
        self_aligning_torque: of the front axle, opposes positive steer
        front_friction_used, rear_friction_used: lateral force over the greatest that the axle can make now
        limit_ahead: 1 where `front_friction_used` is above the tuning's share by its standard deviations, and not held
        limit_distance: by how many of them it is
        front_stiffness, rear_stiffness: true over given cornering stiffness
        friction: true over given friction coefficient
        bank_angle: of the road
        side_force, side_moment: of wind
        steering_friction: dry friction of the steering, true over given
        nis, readings: normalised innovation squared of the sample, and over how many readings
        held: 1 where nothing could be estimated and the last estimate stands
        restarted: 1 where the innovations had been too large for a second, and the filter started anew
    """

    sideslip_angle: Annotated[Any, "rad"]
    sideslip_angle_deviation: Annotated[Any, "rad"]
    lateral_speed: Annotated[Any, "m/s"]
    corrected_yaw_rate: Annotated[Any, "rad/s"]
    front_slip_angle: Annotated[Any, "rad"]
    rear_slip_angle: Annotated[Any, "rad"]
    front_lateral_force: Annotated[Any, "N"]
    rear_lateral_force: Annotated[Any, "N"]
    self_aligning_torque: Annotated[Any, "N*m"]
    self_aligning_torque_deviation: Annotated[Any, "N*m"]
    front_friction_used: Annotated[Any, ""]
    front_friction_used_deviation: Annotated[Any, ""]
    rear_friction_used: Annotated[Any, ""]
    limit_ahead: Annotated[Any, ""]
    limit_distance: Annotated[Any, ""]
    front_stiffness: Annotated[Any, ""]
    front_stiffness_deviation: Annotated[Any, ""]
    front_stiffness_identified: Annotated[Any, ""]
    rear_stiffness: Annotated[Any, ""]
    rear_stiffness_deviation: Annotated[Any, ""]
    rear_stiffness_identified: Annotated[Any, ""]
    friction: Annotated[Any, ""]
    friction_deviation: Annotated[Any, ""]
    friction_identified: Annotated[Any, ""]
    bank_angle: Annotated[Any, "rad"]
    bank_angle_deviation: Annotated[Any, "rad"]
    bank_angle_identified: Annotated[Any, ""]
    side_force: Annotated[Any, "N"]
    side_force_deviation: Annotated[Any, "N"]
    side_force_identified: Annotated[Any, ""]
    steering_friction: Annotated[Any, ""]
    steering_friction_deviation: Annotated[Any, ""]
    lateral_acceleration_bias: Annotated[Any, "m/s**2"]
    yaw_rate_bias: Annotated[Any, "rad/s"]
    road_wheel_angle_offset: Annotated[Any, "rad"]
    nis: Annotated[Any, ""]
    readings: Annotated[Any, ""]
    held: Annotated[Any, ""]
    restarted: Annotated[Any, ""]
