"""Plants of scenarios: cars by name and units by file, and their description."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tierod.core.block import tuning
from tierod.core.fields import numbers, replaced
from tierod.core.files import expanded
from tierod.core.signals import SIGNALS
from tierod.core.toml import build, kind_name
from tierod.core.toml_document import Document
from tierod_lab.ground.cars.catalogue import VirtualCar, by_path, parts_of
from tierod_lab.ground.cars.unit_car import USUAL_STEP, PlantFile, UnitCar, Variables, described, offered
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.courses.course import Start
from tierod_lab.ground.faults.reading import fault_in_words
from tierod_lab.ground.parts import Plant


def facts(scenario: Any) -> list[tuple[str, str]]:
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


def _changes(scenario: Any) -> list[tuple[str, Any]]:
    table = scenario.document.content["car"]
    if not isinstance(table, Mapping):
        return []
    tyres = [("tyres", table["tyres"])] if "tyres" in table else []
    return [*tyres, *by_path(table.get("parts", {})).items(), *by_path(table.get("parameters", {})).items()]


def scenario_document(scenario: Any) -> dict[str, Any]:
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


def plant_car(document: Document, own: Plant) -> tuple[UnitCar, list[str]]:
    """The unit of a plant file, with the driver of a car, and variables whose unit of measurement is assumed."""
    file: PlantFile = build(PlantFile, document.content, document)
    path = Path(file.fmu).expanduser()
    path = expanded(path if path.is_absolute() else document.path.parent / path)
    about = described(path)
    variables = Variables(document, {str(each.name): each for each in about.modelVariables}, [])
    known = {name: each.unit for name, each in SIGNALS.items()}
    known |= {f"truth_{name}": unit for name, unit in known.items()} | {"truth_distance": "m", "truth_speed": "m/s"}
    takes = [variables.wire(("inputs", name), "input", each, offered()) for name, each in file.inputs.items()]
    gives = [variables.wire(("outputs", name), "output", each, known) for name, each in file.outputs.items()]
    begun = {} if file.start_speed is None else {"start_speed": file.start_speed}
    start = [variables.wire((name,), "parameter", each, {name: "m/s"}) for name, each in begun.items()]
    values = [(variables.reference(("values", name), name, "parameter"), each) for name, each in file.values.items()]
    driver: Any = getattr(own, "driver", None)
    if driver is None:
        raise document.error(("fmu",), f"{type(own).__name__} of the scenario has no driver; take a car on a road")
    stated = about.coSimulation.fixedInternalStepSize or getattr(about.defaultExperiment, "stepSize", None)
    step = file.step or float(stated or USUAL_STEP)
    clocks = {name: step for name, _ in tuning(driver) if name.rpartition(".")[2] == "step_time"}
    car = UnitCar(
        path,
        json.dumps((takes, gives, start, values)),
        tuple(each.signal for each in takes),
        tuple((each.signal, each.unit) for each in gives),
        replaced(driver, clocks) if clocks else driver,
        Start(),
        step,
    )
    if lacking := car.lacking():
        raise document.error(("outputs",), f"our driver needs {', '.join(lacking)} of the unit; name the variable here")
    return car, variables.assumed


def native_code(scenarios: Iterable[Any]) -> tuple[str, ...]:
    """A caution for each unit that computes a car of these scenarios; none where all cars are of tierod's own model."""
    paths = dict.fromkeys(each.car.path for each in scenarios if isinstance(each.car, UnitCar))
    return tuple(
        f"{path} runs its own native code on this computer, with all your rights; run only units that you trust"
        for path in paths
    )
