"""Base classes of the courses: along a way, or over time."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses.conditions import Acting, AnyCondition
from tierod_lab.ground.courses.course import Columns, Grid, Start, combine
from tierod_lab.ground.courses.way import TICK, Pace, Plan, Way

TOLERATED_LAG = 3.0  # Dead band of the distance from the plan within which the target speed is not corrected [m]
HASTE = 1.05  # Factor by which a car behind its plan may exceed the speed that the way allows
_CONDITIONS, WAY = 1, 2


def require_rise(first_speed: float, last_speed: float) -> None:
    """Reject a test whose speed [m/s] does not rise."""
    if not first_speed < last_speed:
        raise ParameterError(
            f"the speed of the test would rise from {first_speed:g} to {last_speed:g} m/s; give a last_speed above the "
            "first_speed"
        )


def require_some(what: str, count: int) -> None:
    """Reject a test with a count below one."""
    if count < 1:
        raise ParameterError(f"a test cannot have {count} {what}; give at least 1")


@dataclass(frozen=True)
class Described:
    """Fields of every course."""

    name: str = ""
    description: str = ""
    source: str = ""
    seed: int = 0
    conditions: tuple[AnyCondition, ...] = ()

    def generator(self, *stream: int) -> np.random.Generator:
        """Random generator of one purpose, independent of all others."""
        return np.random.default_rng([self.seed, *stream])

    def __getstate__(self) -> dict[str, Any]:
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
    """Base class of the courses along a way in a lane; each kind of course defines its `way`.

    The speed is planned over time, so that halts end. A car that falls behind the plan catches up, but exceeds the
    speed that the way allows by no more than `HASTE`.
    """

    pace: Pace = field(default_factory=Pace)

    catching_up: ClassVar[float] = 0.2
    """Correction of the target speed per distance from the plan beyond the dead band [1/s]."""

    @cached_property
    def way(self) -> Way:
        raise NotImplementedError

    @cached_property
    def plan(self) -> Plan:
        return self.pace.plan(self.way)

    @property
    def duration(self) -> float:
        return (len(self.plan.speed) - 1) * TICK

    @property
    def start(self) -> Start:
        return Start(speed=max(float(self.plan.speed[0]), 0.0))

    @cached_property
    def _road(self) -> Grid:
        way = self.way
        allowed = self.pace.fastest(way, stopping=False)
        # Acceleration at a speed that is given over distance: v dv/ds.
        rise = np.gradient(0.5 * allowed**2, way.step)
        return Grid(way.step, {"road.curvature": way.curvature, **way.slopes, "allowed": allowed, "rise": rise})

    @cached_property
    def _ahead(self) -> Grid:
        return Grid(self.way.step, {"demand.curvature_ahead": self.way.curvature})

    @cached_property
    def _planned(self) -> Grid:
        return Grid(TICK, self.plan._asdict())

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
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
    """Base class of the open-loop courses without a lane; each kind of course defines `speed_at` and `angle_at`."""

    @property
    def duration(self) -> float:
        raise NotImplementedError

    @property
    def start(self) -> Start:
        return Start(float(self.speed_at(np.zeros(1))[0][0]))

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        raise NotImplementedError

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        raise NotImplementedError

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        wanted, acceleration = self.speed_at(time)
        columns = {
            "demand.speed": wanted,
            "demand.acceleration": acceleration,
            "demand.steering_wheel_angle": self.angle_at(time),
            "demand.attention": np.zeros(len(time)),
        }
        return self._with_conditions(columns, time, distance)
