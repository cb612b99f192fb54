"""The virtual test vehicle: cars, drivers, courses, sensors and faults; never imported by a monitor."""

from tierod.proving_ground.cars.eps_car import EpsCar
from tierod.proving_ground.chassis import SingleTrack, TwoTrack
from tierod.proving_ground.courses.natural import Bends, City, Country, Motorway
from tierod.proving_ground.drives import FrictionCourse, drive, lock_to_lock, with_friction
from tierod.proving_ground.run import Outcome, run
from tierod.proving_ground.scatter import Scatter
from tierod.proving_ground.sensors import Sensor, SensorSet
from tierod.proving_ground.steering.column_eps import ColumnEps
from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.rack_eps import RackEps

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
    "with_friction",
]
