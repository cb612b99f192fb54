"""Parameters of a car in the model of its lateral motion, and its possible unknown states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

UNKNOWNS: dict[str, str] = {
    "log_front_stiffness": "",
    "log_rear_stiffness": "",
    "log_friction": "",
    "bank_angle": "rad",
    "side_force": "N",
    "side_moment": "N*m",
    "lateral_acceleration_bias": "m/s**2",
    "yaw_rate_bias": "rad/s",
    "road_wheel_angle_offset": "rad",
    "log_steering_friction": "",
    "log_trail": "",
}
"""Possible states beside the motion, with units; `log_` is the natural logarithm of the true over the given value."""

OF_STEERING = ("log_steering_friction", "log_trail")
"""Unknowns that need the steering among the states."""


@dataclass(frozen=True)
class LateralParameters:
    """Parameters of a car for the sideslip estimator, named as in a vehicle file.

    Args:
        mass, yaw_inertia: of the vehicle
        front_distance, rear_distance: from the centre of gravity to the axles
        front_cornering_stiffness, rear_cornering_stiffness: of the axles at their static load
        centre_height: of the centre of gravity, above ground
        relaxation_length: of the front axle's lateral force; shorter than that of the tyre, because of the compliance
            of the suspension, which acts later
        rear_relaxation_ratio: relaxation length of the rear axle over that of the front axle
        tyre_friction: peak lateral force over load of the front axle on a dry road
        rear_friction_ratio: friction of the rear axle over that of the front axle
        front_force_shape, rear_force_shape: C of the Magic Formula of the axles, with the compliance of the suspension;
            the higher, the longer the force stays linear
        trail_shape: Ct of the pneumatic trail; above the force's shape the trail vanishes before the peak of the force
        front_load_transfer: load transferred to the outer front wheel per lateral force of the axle; the pneumatic
            trail grows with the load
        stiffness_growth: relative growth of the cornering stiffness per relative growth of the load
        mechanical_trail: of the front axle
        pneumatic_trail: of both axles, without slip
        roll_share: component of gravity in the measured lateral acceleration by roll, per acceleration
        roll_frequency, roll_damping_ratio: natural frequency and damping ratio of the body's roll
        roll_arm: height of the centre of gravity above the roll axis
        sensor_forward: distance of the accelerometer ahead of the centre of gravity
        drive_front_share, brake_front_share: share of the longitudinal force at the front axle
        road_wheel_inertia: of everything that turns with the road wheels, J_w
        road_wheel_damping: viscous, at the road wheels, b_w
        road_wheel_friction: level of dry friction at the road wheels, F_w
        road_wheel_friction_angle: angle over which that friction builds up linearly; 3/4 of the angle of Dahl's law
    """

    mass: Annotated[float, "kg"]
    yaw_inertia: Annotated[float, "kg*m**2"]
    front_distance: Annotated[float, "m"]
    rear_distance: Annotated[float, "m"]
    front_cornering_stiffness: Annotated[float, "N/rad"]
    rear_cornering_stiffness: Annotated[float, "N/rad"]
    centre_height: Annotated[float, "m"] = 0.5
    relaxation_length: Annotated[float, "m"] = 0.3
    rear_relaxation_ratio: Annotated[float, ""] = 1.0
    tyre_friction: Annotated[float, ""] = 1.0
    rear_friction_ratio: Annotated[float, ""] = 1.0
    front_force_shape: Annotated[float, ""] = 1.4
    rear_force_shape: Annotated[float, ""] = 1.4
    trail_shape: Annotated[float, ""] = 1.15
    front_load_transfer: Annotated[float, ""] = 0.3
    stiffness_growth: Annotated[float, ""] = 0.6
    mechanical_trail: Annotated[float, "m"] = 0.023
    pneumatic_trail: Annotated[float, "m"] = 0.03
    roll_share: Annotated[float, ""] = 0.05
    roll_frequency: Annotated[float, "rad/s"] = 14.0
    roll_damping_ratio: Annotated[float, ""] = 0.4
    roll_arm: Annotated[float, "m"] = 0.4
    sensor_forward: Annotated[float, "m"] = 0.0
    drive_front_share: Annotated[float, ""] = 0.5
    brake_front_share: Annotated[float, ""] = 0.65
    road_wheel_inertia: Annotated[float, "kg*m**2"] = 3.5
    road_wheel_damping: Annotated[float, "N*m*s/rad"] = 160.0
    road_wheel_friction: Annotated[float, "N*m"] = 30.0
    road_wheel_friction_angle: Annotated[float, "rad"] = 1.3e-3


@dataclass(frozen=True)
class Sampled:
    """Parameters of the sampled model.

    Args:
        car: as in the vehicle file
        sample_time: sampling interval
        usual: value to which every unknown returns, in their order
        fading: share of the deviation from it that is left after a sample; one for a random walk
    """

    car: LateralParameters
    sample_time: Annotated[float, "s"]
    usual: tuple[float, ...] = ()
    fading: tuple[float, ...] = ()
