"""Parameters of a car in the model of its lateral motion, and their uncertainty."""

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
"""What may be a state beside the motion, and its unit; `log_` is the natural logarithm of true over given value."""

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
        relaxation_length: distance over which the front axle's force builds up; the compliance of the suspension, which
            yields later, makes it shorter than the tyre's
        rear_relaxation_ratio: that of the rear axle over that of the front axle
        tyre_friction: greatest lateral force over load of the front axle on a dry road
        rear_friction_ratio: that of the rear axle over that of the front axle
        front_force_shape, rear_force_shape: C of the Magic Formula of the axles, with the compliance of the suspension;
            the higher, the longer the force stays linear
        trail_shape: Ct of the pneumatic trail; above the force's shape it vanishes before the force has its peak
        front_load_transfer: load that the front axle moves to its outer wheel, per lateral force of the axle; there the
            pneumatic trail is longer
        stiffness_growth: relative growth of the cornering stiffness per relative growth of the load
        mechanical_trail: of the front axle
        pneumatic_trail: of both axles, without slip
        roll_share: what gravity adds to the measured lateral acceleration as the body leans, per acceleration
        roll_frequency, roll_damping_ratio: natural frequency and damping of the body's roll
        roll_arm: of the centre of gravity above the roll axis
        sensor_forward: of the accelerometer, ahead of the centre of gravity
        drive_front_share, brake_front_share: of the force along the road, at the front axle
        road_wheel_inertia: of everything that turns with the road wheels, J_w
        road_wheel_damping: viscous, at the road wheels, b_w
        road_wheel_friction: dry, at the road wheels, F_w
        road_wheel_friction_angle: over which that friction builds up evenly; three quarters of the angle of Dahl's law
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
        sample_time: between two samples
        usual: value to which every unknown returns, in their order
        fading: share of its distance from there that is left after a sample; one for a random walk
    """

    car: LateralParameters
    sample_time: Annotated[float, "s"]
    usual: tuple[float, ...] = ()
    fading: tuple[float, ...] = ()
