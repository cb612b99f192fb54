"""Vehicle files as a user begins them: mass and wheelbase of a brochure, all else typical of the class."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from tierod.core.units import COUNT
from tierod.methods.identification.vehicle import VehicleIdentification
from tierod.vehicles.beginning import begun
from tierod.vehicles.catalogue import QUANTITIES
from tierod.vehicles.classes import Known
from tierod.vehicles.vehicle import Parameter, Vehicle

SOURCE = "brochure"


def brochure_car(name: str, kind: str, mass: float, wheelbase: float, torques_known: bool = True) -> Vehicle:
    """Vehicle as `tierod new NAME.toml --class KIND mass=... wheelbase=...` writes it.

    Args:
        name: of the car
        kind: its class
        mass: [kg]
        wheelbase: [m]
        torques_known: whether its torques are in N*m; counts else, so that no friction in N*m is given

    Raises:
        ParameterError: no such class
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
    """Vehicle as `tierod identify vehicle` leaves it in the file: as before where it gives a reason to doubt.

    Args:
        car: the file before
        found: what drives have identified
    """
    if found.doubt:
        return car
    learnt = {
        each.name: Parameter(each.name, each.value, QUANTITIES[each.name].unit, each.deviation, "identified")
        for each in found.found
    }
    return dataclasses.replace(car, parameters={**car.parameters, **learnt})


def with_values(car: Vehicle, values: Mapping[str, float]) -> Vehicle:
    """The car with values that are exact.

    Args:
        car: whose other parameters stay
        values: by name, in SI units
    """
    exact = {
        name: Parameter(name, value, QUANTITIES[name].unit, 0.0, "the virtual car's own")
        for name, value in values.items()
    }
    return dataclasses.replace(car, parameters={**car.parameters, **exact})
