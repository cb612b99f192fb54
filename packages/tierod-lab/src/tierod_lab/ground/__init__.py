"""The virtual test vehicle: cars, drivers, courses, sensors and faults; never imported by a monitor."""

from tierod_lab.ground.cars.road_cars import EpsCar
from tierod_lab.ground.chassis import SingleTrack, TwoTrack
from tierod_lab.ground.courses.roads import Bends, City, Country, Motorway
from tierod_lab.ground.run import FrictionCourse, Outcome, drive, lock_to_lock, run
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.sensors import Sensor, SensorSet
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.rack_eps import RackEps

__all__ = [
    "Bends",
    "City",
    "ColumnEps",
    "Country",
    "DryFriction",
    "EpsCar",
    "FrictionCourse",
    "Motorway",
    "Outcome",
    "RackEps",
    "Scatter",
    "Sensor",
    "SensorSet",
    "SingleTrack",
    "TwoTrack",
    "drive",
    "lock_to_lock",
    "run",
]
