"""Virtual drives for the tests of the paper's monitors; the car's Dahl angle is the one thing that is varied."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from tierod.core.recording import Aligned
from tierod_lab.ground import EpsCar, FrictionCourse, SensorSet, SingleTrack, drive
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.steering.friction import Dahl
from tierod_lab.papers.friction.refined import FrictionSample

THIN_AIR = 1e12
"""Pressure of a tyre that does not scrub [Pa]."""


def paper_car() -> EpsCar:
    """The car of the paper's equations: one track, a rigid column, nothing from weight or turning patches."""
    car = EpsCar(chassis=SingleTrack(weight_lever=0.0, tyre_pressure=THIN_AIR))
    return replace(car, steering=replace(car.steering, torsion_bar=None))


NAMES = (*FrictionSample._fields, "vehicle_speed")


@lru_cache(maxsize=64)
def driven(
    friction: float | FrictionCourse,
    seed: int = 1,
    dahl_degrees: float = 1.0,
    minutes: float = 9.0,
    rate_noise: float = 0.01,
    scatter: bool = False,
) -> Aligned:
    """A mixed drive at 100 Hz; 0.01 degrees of Dahl angle is Coulomb friction."""
    car = paper_car()
    law = Dahl(math.radians(dahl_degrees))
    car = replace(car, steering=replace(car.steering, friction=replace(car.steering.friction, law=law)))
    sensors = SensorSet.production().only(CHANNELS)
    rate = replace(sensors["steering_wheel_rate"], noise=rate_noise)
    sensors = sensors.with_sensors({"steering_wheel_rate": rate})
    return drive(car, minutes, friction, seed=seed, sensors=sensors, scatter=scatter).align(NAMES, 100.0)


def enabled_seconds(enabled: np.ndarray) -> np.ndarray:
    """Enabled time so far [s]."""
    return np.cumsum(enabled) * 0.01
