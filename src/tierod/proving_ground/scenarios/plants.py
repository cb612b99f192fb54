"""Scenarios whose vehicle is computed by a unit of another tool."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.toml import Document
from tierod.proving_ground.foreign import ForeignCar, car_of, remarks, wiring_of
from tierod.proving_ground.parts import Plant
from tierod.proving_ground.scenarios.scenario import Scenario, require_fault_free


def plant_car(document: Document, own: Plant) -> Plant:
    """The unit of a plant file, with driver and assist unit of a car.

    Args:
        document: the plant file
        own: car of a scenario

    Raises:
        ParameterError: an invalid file, or a unit that lacks a required signal
        InputError: the unit cannot be used
    """
    unit, wiring = wiring_of(document)
    try:
        return car_of(unit, wiring, own)
    except ParameterError as error:
        raise document.error(("outputs",), str(error)) from None


def native_code(scenarios: Iterable[Scenario]) -> tuple[str, ...]:
    """A caution for each unit that computes a car of these scenarios; none where all cars are of tierod's own model.

    Args:
        scenarios: scenarios that are going to run
    """
    paths = dict.fromkeys(each.car.path for each in scenarios if isinstance(each.car, ForeignCar))
    return tuple(
        f"{path} runs its own native code on this computer, with all your rights; run only units that you trust"
        for path in paths
    )


def with_plant(scenario: Scenario, document: Document) -> tuple[Scenario, list[str]]:
    """A scenario with a unit in place of its car, and remarks for the user, in sentences.

    Args:
        scenario: scenario with its own car
        document: the plant file

    Raises:
        ParameterError: an invalid file, a unit that lacks a required signal, or a scenario that the unit cannot drive
        InputError: the unit cannot be used
    """
    unit, wiring = wiring_of(document)
    car = car_of(unit, wiring, scenario.car)
    files = {**scenario.files, unit.path.name: unit.digest}
    driven = replace(scenario, car=car, car_name=f"{unit.name} ({unit.path.name})", files=files)
    require_fault_free(driven)
    acting = scenario.course.columns(np.zeros(1), np.zeros(1), scenario.course.start.speed, 0.0)
    return driven, remarks(car, unit, acting)
