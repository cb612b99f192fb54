"""Witnesses: independent estimates of the yaw rate of a vehicle, and of its steering torque, from single signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tierod.models.rolling_car import RollingCar
from tierod.monitors.condition.signals import WHEELS, CarParameters
from tierod.physics.single_track import understeer_gradient

MOVING = 2.0
"""Speed from which a turn shows in the estimates [m/s]."""


@dataclass(frozen=True)
class Witness:
    """One estimate of a quantity, from one or several signals.

    Args:
        elements: sensors that it uses
        estimate: function that gives the quantity from the signals by name, (n,)
        turned: meaning of a wrong sign, in words
        scaled: meaning of a wrong scale, in words
        lead: time by which it precedes the yaw rate of the vehicle [s]
    """

    elements: tuple[str, ...]
    estimate: Callable[[Mapping[str, np.ndarray], CarParameters], np.ndarray]
    turned: str
    scaled: str = ""
    lead: float = 0.0


def mean_speed(signals: Mapping[str, np.ndarray]) -> np.ndarray:
    """Mean speed of both rear wheels, or speed of the one that is present; signals by name, (n,) each."""
    left, right = signals["wheel_speed_rear_left"], signals["wheel_speed_rear_right"]
    return 0.5 * (np.where(np.isfinite(left), left, right) + np.where(np.isfinite(right), right, left))


def _speed(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    """Speed of the vehicle, corrected by the known scale of its wheel speeds [m/s]."""
    return mean_speed(signals) / vehicle.wheel_speed_scale


YAW_SENSOR, TIMES_SPEED, OVER_SPEED = "yaw rate sensor", ("rear wheels", "steering angle"), "lateral acceleration"
"""Witnesses of the yaw rate: independent of the speed, proportional to it, and inversely proportional to it."""

YAW: dict[str, Witness] = {
    "rear wheels": Witness(
        WHEELS,
        lambda s, p: (s["wheel_speed_rear_right"] - s["wheel_speed_rear_left"]) / (p.wheel_speed_scale * p.track_width),
        "left and right rear wheel speeds are swapped",
        "the track width of the vehicle file, or the unit of the wheel speeds, is wrong",
    ),
    "yaw rate sensor": Witness(
        ("yaw_rate",),
        lambda s, p: s["yaw_rate"],
        "the yaw rate has the wrong sign",
        "the yaw rate has the wrong unit or scale",
    ),
    "steering angle": Witness(
        ("steering_wheel_angle",),
        lambda s, p: s["steering_wheel_angle"] * p.steering_ratio * _speed(s, p) / (p.front_distance + p.rear_distance),
        "the steering angle has the wrong sign",
        "the steering ratio of the vehicle file, or the unit of the steering angle, is wrong",
        0.1,
    ),
    "lateral acceleration": Witness(
        (),
        lambda s, p: s["lateral_acceleration"] / np.maximum(_speed(s, p), MOVING),
        "the lateral acceleration has the wrong sign",
        "the lateral acceleration has the wrong unit or scale",
        0.1,
    ),
}
"""Witnesses of the yaw rate [rad/s]."""


def _understeering(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    """Yaw rate by the steering angle with the understeer of the vehicle file, none where it has no tyres [rad/s]."""
    by_geometry = YAW["steering angle"].estimate(signals, vehicle)
    if not isinstance(vehicle, RollingCar.Parameters):
        return by_geometry
    p = vehicle
    stiffness = p.front_cornering_stiffness, p.rear_cornering_stiffness
    gradient = max(float(understeer_gradient(p.mass, p.front_distance, p.rear_distance, *stiffness)), 0.0)
    return by_geometry / (1.0 + gradient * _speed(signals, vehicle) ** 2 / (p.front_distance + p.rear_distance))


UNDERSTEERING: Mapping[str, Witness] = YAW | {"steering angle": replace(YAW["steering angle"], estimate=_understeering)}
"""The same with the understeer of the vehicle file, which lets a car turn half as much at 25 m/s as by geometry."""

TORQUE: Mapping[str, Witness] = {
    "steering torque sensor": Witness(
        ("steering_shaft_torque",),
        lambda s, p: s["steering_shaft_torque"] - _spring(s, p),
        "the steering torque has the wrong sign",
    ),
    "targets of the steering motors": Witness(
        (),
        lambda s, p: s["steering_motor_1_target_torque"] + s["steering_motor_2_target_torque"] - _spring(s, p),
        "the target torques of the steering motors have the wrong sign",
    ),
    "tie-rod force": Witness(
        ("tie_rod_force",), lambda s, p: p.rack_ratio * s["tie_rod_force"], "the tie-rod force has the wrong sign"
    ),
}
"""Witnesses of the column torque by the tie rods [N*m]; they differ by friction, so that only signs are compared."""


def _spring(signals: Mapping[str, np.ndarray], vehicle: CarParameters) -> np.ndarray:
    return vehicle.rack_ratio**2 * vehicle.rack_stiffness * signals["steering_wheel_angle"]
