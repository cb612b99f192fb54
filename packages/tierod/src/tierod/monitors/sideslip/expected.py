"""Observables that the car of a vehicle file must show in a drive, and their tolerances for fault-free cars."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.monitors.sideslip.observables import Observables
from tierod.physics.single_track import understeer_gradient
from tierod.vehicles.classes import class_of, typical
from tierod.vehicles.uncertain import moved, with_spread
from tierod.vehicles.vehicle import Vehicle


@dataclass(frozen=True)
class Tolerances:
    """Deviations of fault-free cars from their files: standard deviations added to those of the parameters.

    Args:
        turn_usual, turn: mean and standard deviation of the logarithm of lateral acceleration over speed times yaw
            rate; bank makes it smaller, lean larger
        wheelbase: relative, of wheelbase and steering ratio; the ratio varies with the angle, columns twist
        understeer: error of the understeer gradient from nonlinear tyres
        tyres: least relative standard deviation of a cornering stiffness, which is uncertain on another surface
        steering_zero: zero of the road wheels [rad]; 3 degrees at the steering wheel
        sensor_usual, sensor: mean and standard deviation of the accelerometer's place; a delay of some hundredths of a
            second moves it backwards
        sensor_forward: standard deviation of the place about the centre of gravity, where the file gives none
        track: relative, of the rear track; wheel speeds in a turn follow the tyres' centres
        wheel: relative, of the radius of the wheels
        gain: relative, from slopes and slip
        decides: threshold on the squared normalised deviations explained by one hypothesis, 3.2 standard deviations
        file_decides: the same threshold for the vehicle file with its four quantities
        left: probability below which what the accepted hypothesis leaves is no chance
        alike: difference of these up to which two hypotheses cannot be separated
        least: relative error of a scale from which it is reported
    """

    turn_usual: Annotated[float, ""] = -0.03
    turn: Annotated[float, ""] = 0.05
    wheelbase: Annotated[float, ""] = 0.10
    understeer: Annotated[float, "rad*s**2/m"] = 0.0015
    tyres: Annotated[float, ""] = 0.3
    steering_zero: Annotated[float, "rad"] = 0.003
    sensor_usual: Annotated[float, "m"] = -0.2
    sensor: Annotated[float, "m"] = 0.2
    sensor_forward: Annotated[float, "m"] = 0.3
    track: Annotated[float, ""] = 0.05
    wheel: Annotated[float, ""] = 0.03
    gain: Annotated[float, ""] = 0.06
    decides: Annotated[float, ""] = 10.0
    file_decides: Annotated[float, ""] = 16.0
    left: Annotated[float, ""] = 0.01
    alike: Annotated[float, ""] = 4.0
    least: Annotated[float, ""] = 0.08


class Expected(NamedTuple):
    """Expected observables of a vehicle file: values, and standard deviations including the tolerances."""

    values: Observables
    deviations: Observables


def expected(vehicle: Vehicle, tolerances: Tolerances | None = None) -> Expected:
    """Expected observables of a vehicle file.

    Args:
        vehicle: vehicle; parameters without a standard deviation take that of its class
        tolerances: tolerances of fault-free cars
    """
    limits = tolerances or Tolerances()
    car, _ = with_spread(vehicle)
    length = car["front_distance"] + car["rear_distance"]
    spread = {name: each.standard_deviation or 0.0 for name, each in car.parameters.items()}
    known = spread.get("wheelbase", math.hypot(spread["front_distance"], spread["rear_distance"]))
    ratio = spread.get("steering_ratio", 0.0) / car["steering_ratio"]
    if "track_width" in car:
        track, track_spread = car["track_width"], spread["track_width"]
    else:
        usual = typical(class_of(car))["track_width"]
        track, track_spread = usual.value, usual.standard_deviation or 0.0
    forward = car["sensor_forward"] if "sensor_forward" in car.parameters else 0.0
    values = Observables(
        turn=limits.turn_usual,
        wheelbase=length,
        understeer=_understeer(car),
        steering_zero=0.0,
        sensor_place=car["rear_distance"] + forward + limits.sensor_usual,
        track=track,
        wheel=0.0,
        gain=0.0,
    )
    deviations = Observables(
        turn=limits.turn,
        wheelbase=length * math.hypot(known / length, ratio, limits.wheelbase),
        understeer=math.hypot(limits.understeer, *_understeer_moves(car, limits)),
        steering_zero=math.hypot(
            limits.steering_zero, car["steering_ratio"] * spread.get("steering_wheel_angle_offset", 0.0)
        ),
        sensor_place=math.hypot(
            limits.sensor, spread["rear_distance"], spread.get("sensor_forward") or limits.sensor_forward
        ),
        track=math.hypot(track_spread, limits.track * track),
        wheel=math.hypot(limits.wheel, spread.get("wheel_speed_scale", 0.0)),
        gain=limits.gain,
    )
    return Expected(values, deviations)


STEERING = ("mass", "front_distance", "rear_distance", "front_cornering_stiffness", "rear_cornering_stiffness")


def _understeer(car: Vehicle) -> float:
    gradient: float = understeer_gradient(*(car[name] for name in STEERING))
    return gradient


def _understeer_moves(car: Vehicle, limits: Tolerances) -> list[float]:
    """Change of the understeer gradient for one standard deviation of each parameter [rad*s**2/m]."""
    least = {name: limits.tyres * car[name] for name in STEERING[-2:]}
    wider = {
        name: replace(
            car.parameters[name],
            standard_deviation=max(car.parameters[name].standard_deviation or 0.0, least.get(name, 0.0)),
        )
        for name in STEERING
    }
    car = replace(car, parameters={**car.parameters, **wider})
    return [0.5 * (_understeer(moved(car, {name: 1.0})) - _understeer(moved(car, {name: -1.0}))) for name in STEERING]
