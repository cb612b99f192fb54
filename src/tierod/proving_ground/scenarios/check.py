"""Whether the parts of a scenario fit each other, before anything is driven."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.errors import nearest
from tierod.core.fields import numbers
from tierod.core.graph.trace import trace
from tierod.proving_ground.faults import Schedule
from tierod.proving_ground.recorder import channel_names

if TYPE_CHECKING:
    from tierod.proving_ground.scenarios.scenario import Scenario


def require_sound(scenario: Scenario) -> None:
    """Refuse a scenario whose parts contradict each other.

    Raises:
        ParameterError: parts of the car that keep different steps, a course that the car cannot follow, a sensor of a
            channel that it does not have or faster than the car itself, scatter or a fault of what it lacks, a fault
            that begins after the end
    """
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
                f"the car is computed every {step:g} s, but its parameter '{path}' says {number.value:g} s; "
                "make them equal",
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
