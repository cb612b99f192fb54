"""Parameters of the observers matched to a car by slow ramp steer, as on a test track."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np

from tierod.physics.single_track import front_slip_speed, rear_slip_speed
from tierod.vehicles import load
from tierod_lab.ground.courses.manoeuvres import AngleRamp
from tierod_lab.papers.sideslip.setting import CARS, Driven, driven, neutral, steering_ratio
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle

RATE = math.radians(3.0)  # Steering wheel rate [rad/s]: slow against the dynamics of the car

SEEDS = (7001, 7002)  # Seeds of the sensor noise, to the left and to the right


def from_file() -> SteeredVehicle.Parameters:
    """The parameters of the vehicle file."""
    return load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)


@cache
def matched(car: str, speed: float, steer: float, like_neutral: bool = False) -> SteeredVehicle.Parameters:
    """Matched parameters for a car of `CARS`; see `matched_to`.

    Args:
        car: name in `CARS`
        speed: speed [m/s]
        steer: largest road-wheel angle of the test [deg]
        like_neutral: whether the car is made neutral by a softer rear axle
    """
    return matched_to(neutral(CARS[car]()) if like_neutral else CARS[car](), speed, steer)


def matched_to(car: Any, speed: float, steer: float) -> SteeredVehicle.Parameters:
    """Parameters of the vehicle file with cornering stiffnesses and trail matched to a car.

    Ramp steer at constant speed to both sides, with the true sideslip angle as of an optical sensor. Least squares give
    the slopes of axle force over slip angle and of aligning torque over front force. The trail includes every other
    torque in proportion to that force, such as the one of inclined kingpins.

    Args:
        speed: speed [m/s]
        steer: largest road-wheel angle of the test [deg]
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
    """Axle forces [N], slip angles [rad] and aligning torque [N m] during the ramp to one side, (5, n)."""
    sign = 1.0 - 2.0 * side
    course = AngleRamp(speed=speed, angle=sign * steer / steering_ratio(), rate=RATE, settle=2.0, rest=0.0)
    drive = driven(car, course, SEEDS[side])
    rolling = drive.time > 4.0
    return np.array(_axles(drive, p, sign * RATE * steering_ratio()))[:, rolling]


def _axles(drive: Driven, p: SteeredVehicle.Parameters, rate: float) -> tuple[np.ndarray, ...]:
    speed, yaw_rate, steer = (drive.signals[name] for name in ("vehicle_speed", "yaw_rate", "road_wheel_angle"))
    # The ramp is slow enough to neglect the yaw acceleration in the split of the force between the axles.
    sideslip, force = drive.truths["sideslip_angle"], p.mass * drive.truths["centre_lateral_acceleration"]
    wheelbase = p.front_distance + p.rear_distance
    # The wheels turn at a constant rate, so friction and damping are constant and inertia adds nothing.
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
