"""Vehicle files as a user begins them: mass and wheelbase from a brochure, all else typical of the class."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from tierod.core.units import COUNT
from tierod.methods.identification.vehicle import VehicleIdentification
from tierod.vehicles.classes import Known
from tierod.vehicles.vehicle import QUANTITIES, Parameter, Vehicle
from tierod.vehicles.writer import begun

SOURCE = "brochure"  # Source of the brochure values in a vehicle file


def brochure_car(name: str, kind: str, mass: float, wheelbase: float, torques_known: bool = True) -> Vehicle:
    """Vehicle as `tierod new NAME.toml --class KIND mass=... wheelbase=...` writes it, in kg and m.

    Args:
        torques_known: whether its torques are in N*m; otherwise they are counts, and parameters of torque are left out
    """
    known = {"mass": Known(mass, None, SOURCE), "wheelbase": Known(wheelbase, None, SOURCE)}
    _, parameters = begun(known, kind)
    kept = [each for each in parameters if torques_known or not QUANTITIES[each.name].torque]
    return Vehicle(
        name,
        f"{name}, of the class {kind}",
        "begun with typical values of its class",
        (),
        (),
        "N*m" if torques_known else COUNT,
        {each.name: each for each in kept},
        Path(f"{name}.toml"),
    )


def identified(car: Vehicle, found: VehicleIdentification) -> Vehicle:
    """Vehicle as `tierod identify` updates it; unchanged where the identification reports a doubt."""
    if found.doubt:
        return car
    learnt = {
        each.name: Parameter(each.name, each.value, QUANTITIES[each.name].unit, each.deviation, "identified")
        for each in found.found
    }
    return dataclasses.replace(car, parameters={**car.parameters, **learnt})


def with_values(car: Vehicle, values: Mapping[str, float]) -> Vehicle:
    """The vehicle with some parameters replaced by exact values in SI units, of standard deviation 0."""
    exact = {
        name: Parameter(name, value, QUANTITIES[name].unit, 0.0, "the virtual car's own")
        for name, value in values.items()
    }
    return dataclasses.replace(car, parameters={**car.parameters, **exact})
