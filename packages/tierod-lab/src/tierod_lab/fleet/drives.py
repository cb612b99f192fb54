"""Drives of a virtual fleet as recordings: each car is drawn once, each drive has its own road, load and tyres."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod_lab.ground import SensorSet, drive
from tierod_lab.ground.cars.road_cars import EpsCar
from tierod_lab.ground.chassis.two_track import TwoTrack
from tierod_lab.ground.chassis.tyres import TYRES
from tierod_lab.ground.courses.roads import City, Country, Motorway
from tierod_lab.ground.run import CHANNELS
from tierod_lab.ground.scatter import Scatter

_CARS, _ROADS = 77, 78  # Numbers of the random streams of cars and roads

BETWEEN_CARS = Scatter()  # Scatter of the parameters and sensors from car to car, as in the friction study

BETWEEN_DRIVES = Scatter(
    torque_gain=0.0,
    damping=0.0,
    inertia=0.0,
    trail=0.05,
    driver_torque_offset=0.1,
    lateral_acceleration_bias=0.1,
    tyre_stiffness=0.05,
    mass=0.04,
)
"""Scatter from drive to drive of one car: load (standard deviation 64 kg), tyre pressure and wear, zero drift."""

AMBIENT = "ambient_temperature"


@dataclass(frozen=True)
class VirtualDrive:
    """One drive of one car."""

    car: int  # seed of the car's parameters
    road: int  # seed of road, driver, load and noise
    friction: Annotated[float, "N*m"]  # true friction [N*m]
    duration: Annotated[float, "s"]  # duration [s]
    winter: bool = False  # whether the car has winter tyres
    temperature: Annotated[float, "K"] = 288.15

    def recording(self) -> Recording:
        """The drive as measured by the sensors of a production car, with the ambient temperature."""
        car = EpsCar()
        assert isinstance(car.chassis, TwoTrack)
        if self.winter:
            car = replace(car, chassis=car.chassis.on_tyres(TYRES["winter"]))
        sensors = SensorSet.production().only(CHANNELS)
        car, sensors = BETWEEN_CARS.draw(car, sensors, np.random.default_rng([self.car, _CARS]))
        chance = np.random.default_rng([self.road, _ROADS])
        roads = [(City(), Country(), Motorway())[number] for number in chance.permutation(3)]
        found = drive(car, self.duration / 60.0, self.friction, self.road, BETWEEN_DRIVES, sensors, roads)
        first, last = found.span
        time = np.arange(first, last, 10.0)
        air = Channel(AMBIENT, time, np.full(len(time), self.temperature), "K")
        return replace(found, channels={**found.channels, AMBIENT: air})
