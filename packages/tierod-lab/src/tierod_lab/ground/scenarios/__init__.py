"""Scenario files: car, course, duration, sensors and faults of a run, checked before the simulation."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tierod.core.errors import ParameterError, TierodError, nearest
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, replaced
from tierod.core.files import sha256_of
from tierod.core.graph.trace import trace
from tierod.core.plugins import FileRegistry
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes, read_text, toml
from tierod_lab.ground import courses
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.cars.unit_car import UnitCar
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.faults import AtTime, Fault, Schedule, Within, fault_of
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.recorder import channel_names
from tierod_lab.ground.run import Outcome, run, unequal_steps
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.scenarios.plants import plant_car
from tierod_lab.ground.sensors import SensorSet

LONGEST = 14_400.0
"""Longest run [s]; the recording stays in memory, with 0.25 MB per second, ten times that with motor currents."""


@dataclass(frozen=True)
class Scenario:
    """Complete description of one run."""

    name: str
    description: str
    car: Plant
    car_name: str
    course: AnyCourse
    duration: float  # duration [s]
    seed: int
    sensors: SensorSet
    faults: tuple[Fault, ...]
    scatter: Scatter | None  # distribution of car and sensors around their nominal values; None for no scatter
    route_seed: int | None  # seed of the course, if it has its own; None if it uses that of the run
    document: Document
    files: Mapping[str, str]
    vehicle: str = ""  # name of the vehicle file with which monitors judge the car; "" if tierod ships none
    next_command: str = ""  # command line that evaluates the run; "" for the usual monitor of the vehicle

    def with_run(self, seconds: float | None = None, seed: int | None = None) -> Scenario:
        """The same scenario with another duration [s] or seed; faults that would start later are left out."""
        seconds = self.duration if seconds is None else seconds
        seed = self.seed if seed is None else seed
        require_duration(seconds, self.car.step_time)
        course = lengthened(self.course, seconds)
        route = seed if self.route_seed is None else self.route_seed
        faults = tuple(fault for fault in self.faults if _begins_before(fault, seconds))
        return replace(self, course=replace(course, seed=route), duration=seconds, seed=seed, faults=faults)

    @property
    def digest(self) -> str:
        """SHA-256 of the scenario, without comments and layout, and of the files to which it refers; hexadecimal."""
        whole = json.dumps([self.document.content, dict(self.files)], sort_keys=True, default=str)
        return hashlib.sha256(whole.encode()).hexdigest()

    @property
    def provenance(self) -> dict[str, Any]:
        """All data that reproduce the run, as plain data."""
        return {
            "scenario": self.name,
            "scenario_text": self.document.text,
            "scenario_sha256": self.digest,
            "files": dict(self.files),
            "virtual_car": self.car_name,
            **({"vehicle_file": self.vehicle} if self.vehicle else {}),
            **({"plant_wiring": self.car.wiring} if isinstance(self.car, UnitCar) else {}),
            "course": self.course.name,
            "route_seed": self.course.seed,
            "seed": self.seed,
            "seconds": self.duration,
            "tierod_version": version("tierod"),
        }

    def run(self, progress: Callable[[float], None] = lambda share: None) -> Outcome:
        """Simulate the scenario."""
        parts = (self.sensors, self.faults, self.scatter, self.provenance)
        return run(self.car, self.course, self.duration, self.seed, *parts, progress)


def _begins_before(fault: Fault, seconds: float) -> bool:
    trigger = fault.trigger
    if isinstance(trigger, AtTime):
        return trigger.time < seconds
    return not isinstance(trigger, Within) or trigger.latest < seconds


def require_duration(seconds: float, step_time: float) -> None:
    """Reject a duration [s] that is shorter than a step of the car [s] or too long for the memory."""
    if not step_time <= seconds <= LONGEST:
        raise ParameterError(
            f"a run cannot last {seconds:g} s; give at least a step of the car, {step_time:g} s, "
            f"and at most {LONGEST:g} s (4 hours), whose samples fill some gigabytes"
        )


def lengthened(course: AnyCourse, seconds: float) -> AnyCourse:
    """A course that lasts at least a given time [s]."""
    if seconds <= course.duration * (1.0 + 1e-9):
        return course
    time: float | None = getattr(course, "time", None)
    if time is None:
        raise ParameterError(
            f"the course '{course.name}' ends after {course.duration:.6g} s; a run of {seconds:g} s is too long for it"
        )
    longer: AnyCourse = replaced(course, {"time": time + seconds - course.duration})
    return longer


def require_fault_free(scenario: Scenario) -> None:
    """Reject a scenario whose parts contradict each other."""
    if wrong := unequal_steps(scenario.car):
        raise scenario.document.error(("car",), wrong)
    _course_fits(scenario)
    _sensors_fit(scenario)
    car, sensors = scenario.car, scenario.sensors
    if scenario.scatter is not None:
        car, sensors = scenario.scatter.draw(car, sensors, np.random.default_rng(scenario.seed))
    Schedule(scenario.faults, car, sensors, scenario.seed, scenario.duration)


def _course_fits(scenario: Scenario) -> None:
    known = trace(scenario.car).sample
    columns = scenario.course.columns(np.zeros(1), np.zeros(1), scenario.course.start.speed, 0.0)
    for name in columns:
        if name not in known:
            sets = f"the course '{scenario.course.name}' sets '{name}', which the car '{scenario.car_name}'"
            raise scenario.document.error(("course",), f"{sets} does not have{nearest(name, known)}")


def _sensors_fit(scenario: Scenario) -> None:
    channels = channel_names(scenario.car)
    given = scenario.document.content.get("sensors", {})
    named = given if isinstance(given, Mapping) else {}
    for name, sensor in scenario.sensors.items():
        if name not in channels:
            if name in named:
                near = nearest(name, [each for each in channels if not each.startswith("truth_")])
                lacks = f"the car '{scenario.car_name}' has no channel '{name}' that a sensor could read{near}"
                raise scenario.document.error(("sensors", name), lacks)
            continue
        fastest = len(channels[name]) / scenario.car.step_time
        if sensor.rate > fastest * (1.0 + 1e-9):
            raise scenario.document.error(
                ("sensors", name, "rate") if name in named else ("car",),
                f"the sensor of '{name}' reads {sensor.rate:g} times a second, but the car is computed only "
                f"{fastest:g} times; give a lower rate",
            )


def named_files(document: Document) -> dict[str, str]:
    """SHA-256 of all files to which a document refers, also indirectly, by their names as written."""
    found: dict[str, str] = {}
    _collect(document.content, document.path.parent, found)
    return found


def _collect(content: object, folder: Path, found: dict[str, str]) -> None:
    for text in _texts(content):
        path = folder / text
        kind = path.suffix.lower()
        if text in found or kind not in (".toml", ".csv", ".fmu") or not path.is_file():
            continue
        if kind == ".fmu":
            found[text] = sha256_of(path)
            continue
        read = read_bytes(path, "the file", ParameterError, most=MOST_DATA_BYTES)
        found[text] = hashlib.sha256(read).hexdigest()
        if kind == ".toml":
            _collect(toml(read_text(path, "the file", ParameterError), path, ParameterError), path.parent, found)


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
            ("plant",), f"'{name}' is a unit, but 'plant' needs the plant file (.toml) that maps its variables"
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


def with_plant(scenario: Scenario, document: Document) -> tuple[Scenario, list[str]]:
    """A scenario with a unit in place of its car, and remarks for the user, in sentences."""
    car, assumed = plant_car(document, scenario.car)
    files = {**scenario.files, car.path.name: sha256_of(car.path)}
    driven = replace(scenario, car=car, car_name=car.path.stem, files=files)
    require_fault_free(driven)
    said = f"the unit states no unit of measurement for {', '.join(assumed)}: taken as they are"
    return driven, [said] if assumed else []
