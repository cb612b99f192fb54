"""Drives of the virtual car with active front steering, as observers of its motor see them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tierod.core.graph import Result, scan
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.papers.motor_angle.fault_drives import RATE
from tierod.proving_ground import courses
from tierod.proving_ground.cars import catalogue
from tierod.proving_ground.run import run
from tierod.proving_ground.sensors import SensorSet

CAR = "active-front-steering"
"""Name of the car, and of its vehicle file."""


@dataclass(frozen=True)
class CarDrive:
    """A drive, and the truth every ten milliseconds.

    Args:
        samples: of `MotorAngleObserver.Sample`, (n, 5), at `RATE`
        places: samples at which the truth is known, (m,)
        angle, speed: of the motor's shaft [rad], [rad/s], (m,)
    """

    samples: np.ndarray
    places: np.ndarray
    angle: np.ndarray
    speed: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Of the truth, from the first sample on [s]."""
        return self.places / RATE

    def observed(self, observer: Any) -> Result:
        """Outputs of an observer."""
        return scan(observer, self.samples)

    def error(self, observer: Any) -> np.ndarray:
        """Error of its angle where the truth is known [rad]."""
        return self.observed(observer)["motor_angle"][self.places] - self.angle


@lru_cache(maxsize=8)
def car_drive(course: str, seconds: float, seed: int = 1) -> CarDrive:
    """A drive with the sensors of a production car; that of the motor's angle is read ten times as often.

    Args:
        course: of the virtual proving ground
        seconds: how long
        seed: of all chance
    """
    sensors = SensorSet.production()
    angle = replace(dict(sensors.items())["motor_angle_mechanical"], rate=RATE)
    sensors = sensors.with_sensors({"motor_angle_mechanical": angle})
    channels = run(catalogue.load(CAR).block, courses.load(course), seconds, seed, sensors).recording.channels
    samples = np.column_stack([channels[name].values for name in MotorAngleObserver.Sample._fields])
    truth = channels["truth_motor_angle_mechanical"]
    places = np.round(truth.time * RATE).astype(int)
    kept = places < len(samples)
    return CarDrive(samples, places[kept], truth.values[kept], channels["truth_motor_speed"].values[kept])
