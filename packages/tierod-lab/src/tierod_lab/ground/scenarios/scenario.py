"""A scenario, which defines car, course, duration, sensors and faults of a run, and the checks of its consistency."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.core.fields import numbers, replaced
from tierod.core.graph.trace import trace
from tierod.core.toml_document import Document
from tierod_lab.ground.courses import AnyCourse
from tierod_lab.ground.faults import AtTime, Fault, Schedule, Within
from tierod_lab.ground.parts import Plant
from tierod_lab.ground.recorder import channel_names
from tierod_lab.ground.run import Outcome, run
from tierod_lab.ground.scatter import Scatter
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.ground.units.car import UnitCar

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
        """The same scenario with another duration or seed.

        Args:
            seconds: duration [s], unchanged if None; faults that would start later are left out
            seed: seed, unchanged if None
        """
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
        return run(
            self.car,
            self.course,
            self.duration,
            self.seed,
            self.sensors,
            self.faults,
            self.scatter,
            self.provenance,
            progress,
        )


def _begins_before(fault: Fault, seconds: float) -> bool:
    trigger = fault.trigger
    if isinstance(trigger, AtTime):
        return trigger.time < seconds
    return not isinstance(trigger, Within) or trigger.latest < seconds


def require_duration(seconds: float, step_time: float) -> None:
    """Reject a run that is shorter than a step of the car or too long for the memory.

    Args:
        seconds: duration [s]
        step_time: step of the car [s]
    """
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
    _steps_fit(scenario)
    _course_fits(scenario)
    _sensors_fit(scenario)
    car, sensors = scenario.car, scenario.sensors
    if scenario.scatter is not None:
        car, sensors = scenario.scatter.draw(car, sensors, np.random.default_rng(scenario.seed))
    Schedule(scenario.faults, car, sensors, scenario.seed, scenario.duration)


def _steps_fit(scenario: Scenario) -> None:
    step = scenario.car.step_time
    for path, number in numbers(scenario.car).items():
        if path.endswith(".step_time") and number.value != step:
            raise scenario.document.error(
                ("car",),
                f"the car is computed every {step:g} s, but its parameter '{path}' is {number.value:g} s; make them "
                "equal",
            )


def _course_fits(scenario: Scenario) -> None:
    known = trace(scenario.car).sample
    columns = scenario.course.columns(np.zeros(1), np.zeros(1), scenario.course.start.speed, 0.0)
    for name in columns:
        if name not in known:
            raise scenario.document.error(
                ("course",),
                f"the course '{scenario.course.name}' sets '{name}', which the car '{scenario.car_name}' does not have"
                f"{nearest(name, known)}",
            )


def _sensors_fit(scenario: Scenario) -> None:
    channels = channel_names(scenario.car)
    given = scenario.document.content.get("sensors", {})
    named = given if isinstance(given, Mapping) else {}
    for name, sensor in scenario.sensors.items():
        if name in named and name not in channels:
            raise scenario.document.error(
                ("sensors", name),
                f"the car '{scenario.car_name}' has no channel '{name}' that a sensor could read"
                f"{nearest(name, [each for each in channels if not each.startswith('truth_')])}",
            )
        if name in channels:
            fastest = len(channels[name]) / scenario.car.step_time
            if sensor.rate > fastest * (1.0 + 1e-9):
                raise scenario.document.error(
                    ("sensors", name, "rate") if name in named else ("car",),
                    f"the sensor of '{name}' reads {sensor.rate:g} times a second, but the car is computed only "
                    f"{fastest:g} times; give a lower rate",
                )
