"""Vehicles: parameter sets in TOML files, one per car or paper, with unit, spread and source of every value."""

from tierod.vehicles.vehicle import QUANTITIES, VEHICLES, Parameter, Quantity, Vehicle, load, shipped

__all__ = ["QUANTITIES", "VEHICLES", "Parameter", "Quantity", "Vehicle", "load", "shipped"]
