"""Vehicles: parameter sets in TOML files, one per car or paper, with unit, spread and source of every value."""

from tierod.vehicles.catalogue import QUANTITIES, Quantity
from tierod.vehicles.loader import VEHICLES, load, shipped
from tierod.vehicles.vehicle import Parameter, Vehicle

__all__ = ["QUANTITIES", "VEHICLES", "Parameter", "Quantity", "Vehicle", "load", "shipped"]
