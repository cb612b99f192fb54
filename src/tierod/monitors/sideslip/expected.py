"""What a drive must show of the car of a vehicle file, and how far fault-free cars are from that."""

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
    """How far fault-free cars are from what their files give: standard deviations beside those of the parameters.

    Args:
        turn_usual, turn: of lateral acceleration over speed times yaw rate: bank makes it smaller, lean larger
        wheelbase: relative, of wheelbase and steering ratio: the ratio varies with the angle, columns twist
        understeer: of tyres that are not linear
        tyres: least relative one of a cornering stiffness, which means little on another surface
        steering_zero: of the road wheels [rad], 3 degrees at the steering wheel
        sensor_usual, sensor: place of the accelerometer: a sensor that is late by some hundredths of a second seems to
            be farther back
        sensor_forward: of its place about the centre of gravity, where the file gives none
        track: relative, of the rear track: wheel speeds of a turn follow the tyres' centres
        wheel: relative, of the radius of the wheels
        gain: relative, of slopes and slip
        decides: squared deviations that one explanation must take away, 3.2 standard deviations
        file_decides: the same for the vehicle file with its four quantities
        alike: difference of that up to which two explanations are not separated
        least: relative error of a scale from which it is named
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
    alike: Annotated[float, ""] = 4.0
    least: Annotated[float, ""] = 0.08


class Expected(NamedTuple):
    """What a vehicle file gives: values, and standard deviations with the tolerances."""

    values: Observables
    deviations: Observables


def expected(vehicle: Vehicle, tolerances: Tolerances | None = None) -> Expected:
    """What a drive of the car of a file must show.

    Args:
        vehicle: whose parameters without a standard deviation take that of its class
        tolerances: of fault-free cars
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
    """What one standard deviation of each parameter does to the understeer gradient [rad*s**2/m]."""
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
