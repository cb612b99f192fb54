"""Vehicles that another tool computes: functional mock-up units (FMU) in place of a virtual car."""

from __future__ import annotations

from tierod.proving_ground.foreign.car import ForeignCar
from tierod.proving_ground.foreign.description import Unit, read_unit
from tierod.proving_ground.foreign.making import car_of, remarks
from tierod.proving_ground.foreign.wiring import Wiring, wiring_of

__all__ = ["ForeignCar", "Unit", "Wiring", "car_of", "read_unit", "remarks", "wiring_of"]
