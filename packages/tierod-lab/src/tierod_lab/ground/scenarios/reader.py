"""Reading of scenario files, which rejects every error and contradiction before the simulation."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from tierod.core.errors import ParameterError, TierodError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.files import sha256_of
from tierod.core.plugins import FileRegistry
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes, read_text, toml
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.faults import fault_of
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.run import Outcome
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.scenarios.plants import plant_car
from tierod_lab.ground.scenarios.scenario import Scenario, lengthened, require_duration, require_fault_free
from tierod_lab.ground.sensors import SensorSet


def named_files(document: Document) -> dict[str, str]:
    """SHA-256 of all files to which a document refers, also indirectly, by their names as written."""
    found: dict[str, str] = {}
    _collect(document.content, document.path.parent, found)
    return found


def _collect(content: object, folder: Path, found: dict[str, str]) -> None:
    for text in _texts(content):
        path = folder / text
        if text in found or path.suffix.lower() not in (".toml", ".csv", ".fmu") or not path.is_file():
            continue
        found[text] = _digest(path)
        if path.suffix.lower() == ".toml":
            _collect(toml(read_text(path, "the file", ParameterError), path, ParameterError), path.parent, found)


def _digest(path: Path) -> str:
    if path.suffix.lower() == ".fmu":
        return sha256_of(path)
    return hashlib.sha256(read_bytes(path, "the file", ParameterError, most=MOST_DATA_BYTES)).hexdigest()


def _texts(content: object) -> Iterator[str]:
    if isinstance(content, str):
        yield content
    elif isinstance(content, Mapping | list):
        for part in content.values() if isinstance(content, Mapping) else content:
            yield from _texts(part)


SCENARIOS = FileRegistry("tierod.scenarios", "scenario", Path(__file__).parent)
"""Registry of the scenario files of tierod and of installed packages."""


@dataclass(frozen=True)
class CarTable(catalogue.Choice):
    """Table `car` of a scenario: name of the car and changes compared with its file."""

    name: str = ""


@dataclass(frozen=True)
class ScenarioFile:
    """Content of a scenario file."""

    name: str
    description: str
    car: CarTable | str
    course: Any
    seconds: Annotated[float, "s", POSITIVE] | None = None  # duration; that of the course if absent
    seed: Annotated[int, "", NOT_NEGATIVE] = 0
    # sensors of the car; those of a production car if absent
    sensors: SensorSet = field(default_factory=SensorSet.production)
    scatter: Scatter | None = None
    faults: tuple[Mapping[str, Any], ...] = ()  # one table each; none if absent
    # command that evaluates the run ("diagnose --monitor sideslip"), printed after the run; the diagnosis that the
    # vehicle file names if absent
    next_command: str = ""
    # file beside this one, of a unit of another tool that computes the vehicle; driver and assist unit remain those of
    # the car
    plant: str = ""


def shipped() -> tuple[str, ...]:
    """The names of the scenarios that tierod ships, in alphabetical order."""
    return tuple(SCENARIOS.own)


def load(name_or_path: str | Path) -> Scenario:
    """The scenario of a shipped name or of a file."""
    return from_document(Document.read(SCENARIOS.find(str(name_or_path)), "scenario"))


def simulate(
    scenario: str | Path | Scenario,
    seconds: float | None = None,
    seed: int | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Outcome:
    """Simulate a scenario: the sensors' readings and the true values (channels named truth_...).

    Args:
        seconds: duration [s]; that of the scenario if not given
        seed: seed of all random numbers; that of the scenario if not given
    """
    whole = scenario if isinstance(scenario, Scenario) else load(scenario)
    return whole.with_run(seconds, seed).run(progress)


def from_document(document: Document) -> Scenario:
    """The scenario of a document; relative paths in it start at its folder."""
    file = build(ScenarioFile, document.content, document)
    car, vehicle = _car(file.car, document)
    car = _plant(file.plant, car, document) if file.plant else car
    course, route_seed = _course(file.course, document)
    course, duration = _lasting(course, file.seconds, car.step_time, document)
    scenario = Scenario(
        name=file.name,
        description=file.description,
        car=car,
        car_name=file.car if isinstance(file.car, str) else file.car.name,
        course=replace(course, seed=file.seed if route_seed is None else route_seed),
        duration=duration,
        seed=file.seed,
        sensors=file.sensors,
        faults=tuple(fault_of(table, document, ("faults", at)) for at, table in enumerate(file.faults)),
        scatter=file.scatter,
        route_seed=route_seed,
        document=document,
        files=named_files(document),
        vehicle=vehicle,
        next_command=file.next_command,
    )
    require_fault_free(scenario)
    return scenario


def _lasting(course: AnyCourse, seconds: float | None, step_time: float, document: Document) -> tuple[AnyCourse, float]:
    """The course, lengthened if necessary and possible, and the duration of the run [s]."""
    try:
        if seconds is not None:
            require_duration(seconds, step_time)
            course = lengthened(course, seconds)
        duration = course.duration if seconds is None else seconds
        require_duration(duration, step_time)
    except ParameterError as error:
        raise document.error(("course",) if seconds is None else ("seconds",), str(error)) from None
    return course, duration


def _car(given: CarTable | str, document: Document) -> tuple[Plant, str]:
    table = CarTable(name=given) if isinstance(given, str) else given
    if not table.name:
        raise document.error(("car",), f"'car.name' is missing; choose one of: {', '.join(catalogue.shipped())}")
    location = ("car",) if isinstance(given, str) else ("car", "name")
    try:
        car = catalogue.load(table.name, document.path.parent)
    except ParameterError as error:
        raise document.error(location, str(error)) from None
    return car.varied(table, document, ("car",)), car.vehicle


def _plant(name: str, own: Plant, document: Document) -> Plant:
    if name.lower().endswith(".fmu"):
        raise document.error(
            ("plant",),
            f"'{name}' is a unit, but 'plant' needs the plant file (.toml) that maps its variables",
        )
    try:
        return plant_car(document.beside(name, "plant"), own)[0]
    except TierodError as error:
        raise document.error(("plant",), str(error)) from None


def _course(given: object, document: Document) -> tuple[AnyCourse, int | None]:
    table = {"name": given} if isinstance(given, str) else given
    if not isinstance(table, Mapping):
        raise document.error(("course",), "'course' has to be the name of a course, or a table")
    changes = dict(table)
    if isinstance(changes.get("file"), str):
        changes["file"] = str(document.path.parent / changes["file"])
    if "kind" in changes:
        course = build(AnyCourse, changes, document, ("course",))
        return course if course.name else replace(course, name=str(changes["kind"])), changes.get("seed")
    known = courses.shipped()
    name = changes.pop("name", "")
    if not name:
        raise document.error(("course",), f"'course.name' is missing; choose one of: {', '.join(known)}")
    location = ("course",) if isinstance(given, str) else ("course", "name")
    base = _named(str(name), document, location)
    return build(type(base), changes, document, ("course",), base=base), changes.get("seed")


def _named(name: str, document: Document, location: tuple[str, ...]) -> AnyCourse:
    path: str | Path = name
    if name not in courses.shipped() and name.lower().endswith((".toml", ".csv")):
        path = document.path.parent / name
    try:
        return courses.load(path)
    except ParameterError as error:
        raise document.error(location, str(error)) from None
