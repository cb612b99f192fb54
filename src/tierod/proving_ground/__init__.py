"""The virtual test vehicle: car, driver, road, sensors and friction fault; never imported by a monitor."""

from tierod.proving_ground.car import EpsCar
from tierod.proving_ground.drives import drive, lock_to_lock
from tierod.proving_ground.friction_course import FrictionCourse
from tierod.proving_ground.parameters import AssistMap, Chassis, Driver, Steering, TorsionBar
from tierod.proving_ground.road import CITY, COUNTRY, MIXED, MOTORWAY, Bends, Road, RoadKind, random_road
from tierod.proving_ground.scatter import Scatter
from tierod.proving_ground.sensors import Sensor, SensorNoise

__all__ = [
    "CITY",
    "COUNTRY",
    "MIXED",
    "MOTORWAY",
    "AssistMap",
    "Bends",
    "Chassis",
    "Driver",
    "EpsCar",
    "FrictionCourse",
    "Road",
    "RoadKind",
    "Scatter",
    "Sensor",
    "SensorNoise",
    "Steering",
    "TorsionBar",
    "drive",
    "lock_to_lock",
    "random_road",
]
