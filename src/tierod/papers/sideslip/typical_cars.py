"""Cars of which only tape and scale are known: typical tyres, default noises, and simple estimates beside."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.monitors.sideslip.beside_truth import BesideTruth
from tierod.papers.sideslip import rivals
from tierod.physics.single_track import front_axle_load
from tierod.vehicles.vehicle import Parameter, Vehicle

SLOWEST = 1.0
"""Speed below which the simple estimates divide by this [m/s]."""

LINEAR_NOISES = {"yaw_rate": 0.01, "lateral_acceleration": 0.5, "sideslip_drift": 0.02, "yaw_drift": 0.3}
"""Of the linear Kalman filter, as one would guess them; its stiffnesses are those of the car."""


@dataclass(frozen=True)
class Class:
    """Typical values of a class of cars; assumed.

    Args:
        front_stiffness, rear_stiffness: cornering stiffness of an axle over its load [1/rad]
        friction: of its tyres on a dry road
    """

    front_stiffness: float
    rear_stiffness: float
    friction: float


PASSENGER = Class(12.0, 17.0, 1.0)
"""Stiffness of a 205 mm summer tyre less the compliance of a steered and of a fixed axle."""

SPORTS = Class(15.0, 21.0, 1.2)
"""Tyres a quarter stiffer, of more grip."""

LIGHT = Class(10.5, 13.0, 0.9)
"""Narrow tyres of low pressure, as of quadricycles."""


def typical(car: Vehicle, kind: Class, **known: float) -> Vehicle:
    """A car as tape, scale and brochure give it: no noise and no tyre of its file.

    Args:
        car: whose mass, distances, steering ratio and driven axle are taken
        kind: class of its tyres
        known: values in their place, such as a distance with the error of the tape
    """
    kept = ("mass", "front_distance", "rear_distance", "steering_ratio", "drive_front_share")
    values = {name: car[name] for name in kept if name in car} | known
    mass, front, rear = (values[name] for name in kept[:3])
    values |= {
        "yaw_inertia": mass * front * rear,
        "front_cornering_stiffness": kind.front_stiffness * front_axle_load(mass, front, rear),
        "rear_cornering_stiffness": kind.rear_stiffness * front_axle_load(mass, rear, front),
        "tyre_friction": kind.friction,
    }
    parameters = {
        name: Parameter(name, value, car.parameters[name].unit if name in car else "", None, "assumed: typical")
        for name, value in values.items()
    }
    return replace(car, parameters=parameters)


def measured_wrong(car: Vehicle, kind: Class, tape: float = 0.03, scale: float = 0.03) -> tuple[Vehicle, ...]:
    """The typical car with the errors of tape [m] and scale (relative) in their corners; the right one comes first."""
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
    """atan(rear distance * yaw rate / speed): tyres that do not slip."""
    speed, yaw_rate = _motion(recording, rate)
    return rivals.beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed), rate)


def steady(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """The same less the slip of the rear axle in a steady turn, with linear tyres."""
    speed, yaw_rate = _motion(recording, rate)
    wheelbase = car["front_distance"] + car["rear_distance"]
    force = car["mass"] * car["front_distance"] / wheelbase * speed * yaw_rate
    slip = force / car["rear_cornering_stiffness"]
    return rivals.beside(recording, np.arctan(car["rear_distance"] * yaw_rate / speed - slip), rate)


def linear_kalman(recording: Recording, car: Vehicle, rate: float) -> BesideTruth:
    """A Kalman filter of the linear single track with the same typical tyres."""
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
"""Estimates that a user would otherwise take, by name."""


def _motion(recording: Recording, rate: float) -> tuple[np.ndarray, np.ndarray]:
    _, values = rivals.signals(recording, ("vehicle_speed", "yaw_rate"), rate)
    return np.maximum(values[:, 0], SLOWEST), values[:, 1]
