"""Common part of the kinds of courses: over a way, or over time."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.proving_ground.courses.conditions import Acting, AnyCondition
from tierod.proving_ground.courses.course import Columns, Grid, Start, combine
from tierod.proving_ground.courses.way import TICK, Pace, Plan, Way

TOLERATED_LAG = 3.0
"""A car may be so far [m] behind or ahead of its plan before it is hurried or held back."""
HASTE = 1.05
"""A car behind its plan may drive so much faster than the way allows."""
_CONDITIONS, WAY = 1, 2


def require_rise(first_speed: float, last_speed: float) -> None:
    """Refuse speeds [m/s] of a test that do not rise.

    Raises:
        ParameterError: the last one is not above the first one
    """
    if not first_speed < last_speed:
        raise ParameterError(
            f"the speed of the test would rise from {first_speed:g} to {last_speed:g} m/s; give a last_speed above the "
            "first_speed"
        )


def require_some(what: str, count: int) -> None:
    """Refuse a test of nothing.

    Raises:
        ParameterError: the count is not positive
    """
    if count < 1:
        raise ParameterError(f"a test with {count} {what} is none; give at least 1")


@dataclass(frozen=True)
class Described:
    """Fields of every course.

    Args:
        name: for messages and provenance
        description: one sentence
        source: where it comes from
        seed: of all that is left to chance
        conditions: road, air and hands
    """

    name: str = ""
    description: str = ""
    source: str = ""
    seed: int = 0
    conditions: tuple[AnyCondition, ...] = ()

    def generator(self, *stream: int) -> np.random.Generator:
        """A source of chance of its own for every purpose."""
        return np.random.default_rng([self.seed, *stream])

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone: what was worked out from them is worked out again where a course is sent."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def _acting(self) -> list[Acting]:
        return [each.acting(self.generator(_CONDITIONS, place)) for place, each in enumerate(self.conditions)]

    def _with_conditions(self, columns: Columns, time: np.ndarray, distance: np.ndarray) -> Columns:
        for act in self._acting:
            combine(columns, act(time, distance))
        return columns


@dataclass(frozen=True)
class WayCourse(Described):
    """Base of the courses that lead along a way in a lane; a kind of course gives its `way`.

    The speed is planned over time, so that halts end; a car that falls behind catches up, but never takes a bend
    faster than the way allows.

    Args:
        pace: how the driver takes it
    """

    pace: Pace = field(default_factory=Pace)

    catching_up: ClassVar[float] = 0.2
    """Speed per distance behind plan beyond what is tolerated [1/s]."""

    @cached_property
    def way(self) -> Way:
        """The road, and where it stops."""
        raise NotImplementedError

    @cached_property
    def plan(self) -> Plan:
        """Plan of the car's place over time."""
        return self.pace.plan(self.way)

    @property
    def duration(self) -> float:
        """Planned duration [s]."""
        return (len(self.plan.speed) - 1) * TICK

    @property
    def start(self) -> Start:
        """At the speed that the way begins with."""
        return Start(speed=max(float(self.plan.speed[0]), 0.0))

    @cached_property
    def _road(self) -> Grid:
        way = self.way
        allowed = self.pace.fastest(way, stopping=False)
        rise = np.gradient(0.5 * allowed**2, way.step)
        return Grid(way.step, {"road.curvature": way.curvature, **way.slopes, "allowed": allowed, "rise": rise})

    @cached_property
    def _ahead(self) -> Grid:
        return Grid(self.way.step, {"demand.curvature_ahead": self.way.curvature})

    @cached_property
    def _planned(self) -> Grid:
        return Grid(TICK, self.plan._asdict())

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
        columns, planned = self._road.at(distance), self._planned.at(time)
        columns |= self._ahead.at(distance + speed * ahead)
        allowed, rise = HASTE * columns.pop("allowed"), columns.pop("rise")
        lag = planned["distance"] - distance
        lag -= np.minimum(np.maximum(lag, -TOLERATED_LAG), TOLERATED_LAG)
        wanted = planned["speed"] + self.catching_up * lag
        hurried = wanted > allowed
        columns["demand.speed"] = np.maximum(np.where(hurried, allowed, wanted), 0.0)
        columns["demand.acceleration"] = np.where(hurried, rise, planned["acceleration"])
        return self._with_conditions(columns, time, distance)


@dataclass(frozen=True)
class TimeCourse(Described):
    """Base of the open-loop courses without a lane; a kind of course gives `speed_at` and `angle_at`."""

    @property
    def duration(self) -> float:
        """Duration of the whole course [s]."""
        raise NotImplementedError

    @property
    def start(self) -> Start:
        """At the speed of the first instant, straight ahead."""
        return Start(float(self.speed_at(np.zeros(1))[0][0]))

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Wanted speed [m/s] and acceleration [m/s**2] at some instants."""
        raise NotImplementedError

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        """Wanted steering-wheel angle [rad] at some instants."""
        raise NotImplementedError

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
        wanted, acceleration = self.speed_at(time)
        columns = {
            "demand.speed": wanted,
            "demand.acceleration": acceleration,
            "demand.steering_wheel_angle": self.angle_at(time),
            "demand.attention": np.zeros(len(time)),
        }
        return self._with_conditions(columns, time, distance)
