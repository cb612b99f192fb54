"""The demonstrator: rounds, sensors, and the differences between vehicles."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tierod.core.fields import numbers, replaced
from tierod_lab.ground.cars.road_cars import DemonstratorCar
from tierod_lab.ground.courses import AnyCourse, load
from tierod_lab.ground.courses.roads import Circuit, drawn, weather
from tierod_lab.ground.drivers import Split
from tierod_lab.ground.sensors import SensorSet

SHORT, LONG, THIRD = "short-round", "long-round", "third-round"
"""Rounds of the tests, similar to Figures 18, 19 and 24 of Li, Frey, Gauterin."""


@lru_cache(maxsize=64)
def course(name: str, seconds: float, seed: int = 0) -> AnyCourse:
    """A shipped course or a random round, a round with weather and slopes.

    Args:
        name: name of a shipped course, or "round-17" for a random round
        seconds: duration of the drive on a round [s]
        seed: seed of slopes, unevenness and wind; the path depends on the name alone
    """
    way = drawn(int(name.removeprefix("round-"))) if name.startswith("round-") else load(name)
    if not isinstance(way, Circuit):
        return way
    return replace(way, time=seconds, seed=seed, conditions=(*way.conditions, *weather(seed, way.length)))


MEASURED = (
    "wheel_speed_rear_left",
    "wheel_speed_rear_right",
    "yaw_rate",
    "steering_wheel_angle",
    "steering_shaft_torque",
    "tie_rod_force",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "steering_motor_1_target_torque",
    "steering_motor_2_target_torque",
    "target_drive_torque_left",
    "target_drive_torque_right",
    "target_steering_wheel_angle",
    "target_vehicle_speed",
)
"""Channels that the demonstrator records for its monitor, at 100 Hz each."""

SWING = Split(share=0.5, swing=0.15, period=0.24)
"""Split of the steering torque that makes the motors isolable: 65 to 35 and back every 0.12 s."""

OFF = {
    ("chassis.mass", "chassis.yaw_inertia"): (0.04, 0.08),
    ("chassis.front.tyre.cornering_stiffness",): (0.05, 0.10),
    ("chassis.rear.tyre.cornering_stiffness",): (0.05, 0.10),
    ("steering.rack.friction.level",): (0.05, 0.20),
    ("steering.rack.rack_damping",): (0.05, 0.20),
    ("steering.rack.centring",): (0.05, 0.20),
}
"""Range of the relative deviation from the nominal vehicle, of either sign; fields of one key share a draw.

Source: mass and stiffness as in the richer simulations beside Li, Frey, Gauterin; friction, damping and centring are
assumed.
"""

RADIUS, SIDES = (0.025, 0.05), 0.006
"""Range of the relative deviation of all tyre radii, and largest difference between left and right [-]."""

OFFSETS = {
    "yaw_rate": 0.003,
    "steering_wheel_angle": 0.02,
    "steering_shaft_torque": 0.05,
    "tie_rod_force": 15.0,
    "longitudinal_acceleration": 0.05,
    "lateral_acceleration": 0.08,
}
"""Standard deviation of the constant offset of every sensor, in the unit of its signal; as of production sensors."""


class Vehicle(NamedTuple):
    """A demonstrator and its sensors."""

    car: DemonstratorCar
    sensors: SensorSet


LATER = {
    "mass": ("chassis.mass", "chassis.yaw_inertia"),
    "stiffness": ("chassis.front.tyre.cornering_stiffness", "chassis.rear.tyre.cornering_stiffness"),
    "radius": ("chassis.front.tyre.radius", "chassis.rear.tyre.radius"),
}
"""Property that may change after a calibration (load, tyres, tyre pressure) -> fields of the vehicle."""


def changed(of: Vehicle, what: str, factor: float) -> Vehicle:
    """A vehicle with a property that has changed since its calibration.

    Args:
        what: a property in `LATER`
    """
    known = numbers(of.car)
    car = replaced(of.car, {path: factor * known[path].value for path in LATER[what]})
    if what != "radius":
        return Vehicle(car, of.sensors)
    # The wheel speeds are still computed with the former radius, so they read low on larger tyres.
    names = ("wheel_speed_rear_left", "wheel_speed_rear_right")
    gains = {f"sensors.{name}.gain": of.sensors[name].gain / factor for name in names}
    return Vehicle(car, replaced(of.sensors, gains))


@lru_cache(maxsize=32)
def vehicle(number: int, swing: bool = True) -> Vehicle:
    """A demonstrator that deviates at random from the nominal one.

    Args:
        number: 0 for the nominal one with production sensors; any other is the seed of the deviations
        swing: whether the split of the steering torque between both motors alternates
    """
    car, sensors = DemonstratorCar(), SensorSet.production().only(MEASURED)
    if swing:
        car = replace(car, driver=replace(car.driver, split=SWING))
    if number == 0:
        return Vehicle(car, sensors)
    chance = np.random.default_rng([number, 611])
    changes: dict[str, float] = {}
    known = numbers(car)
    for paths, band in OFF.items():
        factor = 1.0 + _signed(chance, band)
        changes |= {path: known[path].value * factor for path in paths}
    common, sides = _signed(chance, RADIUS), _signed(chance, (0.5 * SIDES, SIDES))
    for axle in ("front", "rear"):
        path = f"chassis.{axle}.tyre.radius"
        changes[path] = known[path].value * (1.0 + common)
    gains = {
        "wheel_speed_rear_left": 1.0 / (1.0 + common + 0.5 * sides),
        "wheel_speed_rear_right": 1.0 / (1.0 + common - 0.5 * sides),
    }
    wrong = {f"{name}.gain": gain for name, gain in gains.items()}
    wrong |= {f"{name}.bias": deviation * float(chance.standard_normal()) for name, deviation in OFFSETS.items()}
    return Vehicle(
        replaced(car, changes), replaced(sensors, {f"sensors.{path}": value for path, value in wrong.items()})
    )


def _signed(chance: np.random.Generator, band: tuple[float, float]) -> float:
    return float(chance.choice((-1.0, 1.0)) * chance.uniform(*band))
