"""Parameters of the observers matched to a car on slow circles, as one would on a test track."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np

from tierod.models.steered_vehicle import SteeredVehicle
from tierod.papers.sideslip.setting import CARS, Driven, driven, neutral, steering_ratio
from tierod.physics.single_track import front_slip_speed, rear_slip_speed
from tierod.proving_ground.courses.open_loop import AngleRamp
from tierod.vehicles import load

RATE = math.radians(3.0)
"""At which the steering wheel is turned [rad/s]: slow beside the car."""

SEEDS = (7001, 7002)
"""Of the sensors, left and right."""


def from_file() -> SteeredVehicle.Parameters:
    """The parameters of the vehicle file."""
    return load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)


@cache
def matched(car: str, speed: float, steer: float, like_neutral: bool = False) -> SteeredVehicle.Parameters:
    """`matched_to` for a car of `CARS`.

    Args:
        car: name in `CARS`
        speed: [m/s]
        steer: at the road wheels, to which the circles go [deg]
        like_neutral: whether the rear axle is softened
    """
    return matched_to(neutral(CARS[car]()) if like_neutral else CARS[car](), speed, steer)


def matched_to(car: Any, speed: float, steer: float) -> SteeredVehicle.Parameters:
    """The vehicle file with cornering stiffnesses and trail matched to a car.

    Ever more steering at one speed to both sides, up to the steer of the test, with an optical sensor for the sideslip
    angle: slopes of axle force over slip angle, and of aligning torque over front force, by least squares. The trail
    takes in whatever else turns the wheels back in proportion, such as kingpins that lift the car.

    Args:
        car: of the proving ground
        speed: [m/s]
        steer: at the road wheels, to which the circles go [deg]
    """
    p = from_file()
    columns = np.hstack([_circle(car, p, speed, math.radians(steer), side) for side in (0, 1)])
    front, rear, front_slip, rear_slip, torque = columns
    trail = _slope(front, torque)
    return dataclasses.replace(
        p,
        front_cornering_stiffness=_slope(front_slip, front),
        rear_cornering_stiffness=_slope(rear_slip, rear),
        pneumatic_trail=trail - p.mechanical_trail,
    )


def _circle(car: Any, p: SteeredVehicle.Parameters, speed: float, steer: float, side: int) -> np.ndarray:
    """Forces of the axles, slip angles, aligning torque while the wheel is turned to one side, (5, n)."""
    sign = 1.0 - 2.0 * side
    course = AngleRamp(speed=speed, angle=sign * steer / steering_ratio(), rate=RATE, settle=2.0, rest=0.0)
    drive = driven(car, course, SEEDS[side])
    rolling = drive.time > 4.0
    return np.array(_axles(drive, p, sign * RATE * steering_ratio()))[:, rolling]


def _axles(drive: Driven, p: SteeredVehicle.Parameters, rate: float) -> tuple[np.ndarray, ...]:
    speed, yaw_rate, steer = (drive.signals[name] for name in ("vehicle_speed", "yaw_rate", "road_wheel_angle"))
    sideslip, force = drive.truths["sideslip_angle"], p.mass * drive.truths["centre_lateral_acceleration"]
    wheelbase = p.front_distance + p.rear_distance
    resisting = p.road_wheel_damping * rate + math.copysign(p.road_wheel_friction, rate)
    return (
        force * p.rear_distance / wheelbase,
        force * p.front_distance / wheelbase,
        front_slip_speed(speed * sideslip, yaw_rate, speed, steer, p.front_distance) / speed,
        rear_slip_speed(speed * sideslip, yaw_rate, p.rear_distance) / speed,
        drive.torque() - resisting,
    )


def _slope(x: np.ndarray, y: np.ndarray) -> float:
    return float(x @ y / (x @ x))
