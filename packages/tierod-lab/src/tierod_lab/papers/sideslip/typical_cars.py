"""Vehicle files from tape measure and scale alone, with typical tyres; simple estimators for comparison."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.physics.single_track import front_axle_load
from tierod.vehicles.vehicle import Parameter, Vehicle
from tierod_lab.papers.sideslip import rivals
from tierod_lab.papers.sideslip.calibration import BesideTruth

SLOWEST = 1.0
"""Lower bound of the speed by which the simple estimates divide [m/s]."""

LINEAR_NOISES = {"yaw_rate": 0.01, "lateral_acceleration": 0.5, "sideslip_drift": 0.02, "yaw_drift": 0.3}
"""Guessed noises and drifts of the linear Kalman filter; its stiffnesses are those of the vehicle file."""


@dataclass(frozen=True)
class Class:
    """Typical tyres of a class of cars; assumed.

    Args:
        front_stiffness, rear_stiffness: cornering stiffness of an axle over its load [1/rad]
        friction: friction of the tyres on a dry road [-]
    """

    front_stiffness: float
    rear_stiffness: float
    friction: float


PASSENGER = Class(12.0, 17.0, 1.0)
"""205 mm summer tyres, softened by the compliance of a steered and of a fixed axle."""

SPORTS = Class(15.0, 21.0, 1.2)
"""Tyres that are 25 % stiffer and have 20 % more grip than those of `PASSENGER`."""

LIGHT = Class(10.5, 13.0, 0.9)
"""Narrow tyres of low pressure, as on quadricycles."""


def typical(car: Vehicle, kind: Class, **known: float) -> Vehicle:
    """Vehicle file as from tape measure, scale and brochure: without fitted tyres and noises.

    Args:
        car: vehicle file that gives mass, axle distances, steering ratio and drive share
        kind: class of its tyres
        known: parameters that replace those of the file, such as a distance with a measuring error
    """
    kept = ("mass", "front_distance", "rear_distance", "steering_ratio", "drive_front_share")
    values = {name: car[name] for name in kept if name in car} | known
    mass, front, rear = (values[name] for name in kept[:3])
    values |= {
        # The usual estimate where none is measured: a dynamic index of one.
        "yaw_inertia": mass * front * rear,
        "front_cornering_stiffness": kind.front_stiffness * front_axle_load(mass, front, rear),
        # With the distances swapped: load of the rear axle.
        "rear_cornering_stiffness": kind.rear_stiffness * front_axle_load(mass, rear, front),
        "tyre_friction": kind.friction,
    }
    parameters = {
        name: Parameter(name, value, car.parameters[name].unit if name in car else "", None, "assumed: typical")
        for name, value in values.items()
    }
    return replace(car, parameters=parameters)


def measured_wrong(car: Vehicle, kind: Class, tape: float = 0.03, scale: float = 0.03) -> tuple[Vehicle, ...]:
    """Typical files with errors of tape [m] and scale (relative): first without error, then all eight corners."""
    corners = [(0.0, 0.0, 0.0), *((a, b, c) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0))]
    return tuple(
        typical(
            car,
            kind,
            front_distance=car["front_distance"] + front * tape,
            rear_distance=car["rear_distance"] + rear * tape,
            mass=car["mass"] * (1.0 + mass * scale),
        )
        for front, rear, mass in corners
    )


def kinematic(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """Sideslip angle as atan(rear distance * yaw rate / speed), without slip of the rear tyres."""
    speed, yaw_rate = _motion(recording, rate)
    return rivals.beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed), rate)


def steady(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """The kinematic sideslip angle less the slip angle of the rear axle in a steady turn, with linear tyres."""
    speed, yaw_rate = _motion(recording, rate)
    wheelbase = car["front_distance"] + car["rear_distance"]
    force = car["mass"] * car["front_distance"] / wheelbase * speed * yaw_rate
    slip = force / car["rear_cornering_stiffness"]
    return rivals.beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed - slip), rate)


def linear_kalman(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """A Kalman filter of the linear single-track model with the same typical tyres."""
    names = ("vehicle_speed", "yaw_rate", "lateral_acceleration", "road_wheel_angle", "steering_wheel_angle")
    _, values = rivals.signals(recording, names, rate)
    angle = np.where(np.isfinite(values[:, 3]), values[:, 3], car["steering_ratio"] * values[:, 4])
    stiffness = {axle: car[f"{axle}_cornering_stiffness"] for axle in ("front", "rear")}
    filter = rivals.linear_filter(car, LINEAR_NOISES | stiffness, rate)
    speed = np.maximum(values[:, 0], 2.0 * SLOWEST)
    out = scan(filter, np.column_stack([angle, speed, values[:, 1:3]]))
    return rivals.beside(recording, out["mean.sideslip_angle"], rate)


SIMPLE = {
    "kinematics": kinematic,
    "steady single track": steady,
    "linear Kalman filter": linear_kalman,
}
"""Name in the tables -> simple estimator, which a user would take otherwise."""


def _motion(recording: Recording, rate: float) -> tuple[np.ndarray, np.ndarray]:
    _, values = rivals.signals(recording, ("vehicle_speed", "yaw_rate"), rate)
    return np.maximum(values[:, 0], SLOWEST), values[:, 1]
