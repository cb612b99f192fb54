"""Descriptions of scenarios, virtual cars and courses in words and as plain data, for lists and reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from tierod.core.fields import numbers
from tierod.core.toml import kind_name
from tierod_lab.ground.cars.catalogue import VirtualCar, by_path
from tierod_lab.ground.cars.kinds import parts_of
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.faults.wording import fault_in_words
from tierod_lab.ground.scenarios.scenario import Scenario


def facts(scenario: Scenario) -> list[tuple[str, str]]:
    """Facts about a scenario, as pairs of label and text."""
    parts = ", ".join(part for place, part in parts_of(scenario.car).items() if "." not in place)
    sensors = scenario.sensors
    found = [
        ("car", f"{scenario.car_name}{f' ({parts})' if parts else ''}"),
        *(("", f"{path} = {value}") for path, value in _changes(scenario)),
        *([("judged as", f"vehicle {scenario.vehicle}")] if scenario.vehicle else []),
        ("course", f"{scenario.course.name}: {scenario.course.description}"),
        ("duration", f"{scenario.duration:.6g} s"),
        ("seed", str(scenario.seed)),
        ("sensors", sensors.description or f"{len(sensors.items())} channels"),
    ]
    if scenario.scatter is not None:
        found.append(("scatter", "car and sensors are drawn anew for every seed"))
    return found + [("fault", text) for text in map(fault_in_words, scenario.faults)]


def _changes(scenario: Scenario) -> list[tuple[str, Any]]:
    table = scenario.document.content["car"]
    if not isinstance(table, Mapping):
        return []
    tyres = [("tyres", table["tyres"])] if "tyres" in table else []
    return [*tyres, *by_path(table.get("parts", {})).items(), *by_path(table.get("parameters", {})).items()]


def scenario_document(scenario: Scenario) -> dict[str, Any]:
    """A scenario as plain data."""
    return {
        "name": scenario.name,
        "description": scenario.description,
        "car": scenario.car_name,
        "changes": dict(_changes(scenario)),
        "vehicle": scenario.vehicle or None,
        "course": scenario.course.name,
        "seconds": scenario.duration,
        "seed": scenario.seed,
        "sensors": [channel for channel, _ in scenario.sensors.items()],
        "scatter": scenario.scatter is not None,
        "faults": [fault_in_words(fault) for fault in scenario.faults],
    }


def car_document(car: VirtualCar) -> dict[str, Any]:
    """A virtual car as plain data, with every parameter."""
    file = {name: value for name, value in asdict(car.file).items() if name not in ("parameters", "parts")}
    parameters = [
        {"name": path, "value": each.value, "unit": each.unit, "source": car.source_of(path) or "default of its part"}
        for path, each in numbers(car.block).items()
    ]
    return file | {"vehicle": car.vehicle or None, "parts": parts_of(car.block), "parameters": parameters}


def course_document(course: AnyCourse) -> dict[str, Any]:
    """A course as plain data."""
    return {
        "name": course.name,
        "description": course.description,
        "source": course.source,
        "kind": kind_name(type(course)),
        "duration": course.duration,
        "parameters": [
            {"name": path, "value": each.value, "unit": each.unit} for path, each in numbers(course).items()
        ],
    }
