"""Tests along a lane: straight, slalom, double lane change, circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.courses.base import WayCourse, require_rise, require_some
from tierod_lab.ground.courses.way import STEP, TICK, Plan, Way, across

_POINT = 0.05  # Spacing of the points that define a line [m]


@dataclass(frozen=True)
class AtWill(WayCourse):
    """Base class of the tests with a given speed over time: a car behind its plan does not catch up."""

    catching_up: ClassVar[float] = 0.0


@dataclass(frozen=True)
class StraightLane(AtWill):
    """Straight road at constant speed; its conditions make the test: hands off, crosswind, torque steps."""

    speed: Annotated[float, "m/s", POSITIVE] = 80.0 / 3.6
    time: Annotated[float, "s", POSITIVE] = 60.0

    @cached_property
    def way(self) -> Way:
        return _level(np.zeros(math.ceil(self.speed * self.time / STEP) + 2), self.speed)

    @property
    def duration(self) -> float:
        return self.time


@dataclass(frozen=True)
class Slalom(AtWill):
    """Slalom around a row of cones."""

    speed: Annotated[float, "m/s", POSITIVE] = 36.0 / 3.6
    spacing: Annotated[float, "m", POSITIVE] = 18.0
    cones: int = 10
    swing: Annotated[float, "m", POSITIVE] = 1.2
    approach: Annotated[float, "m", POSITIVE] = 60.0

    def __post_init__(self) -> None:
        require_some("cones", self.cones)

    @cached_property
    def way(self) -> Way:
        long = self.spacing * (self.cones + 1)
        forward = np.arange(0.0, long + 2.0 * self.approach, _POINT)
        place = (forward - self.approach) / self.spacing
        fade = _step(place) * _step(self.cones + 1 - place)
        left = self.swing * fade * np.cos(math.pi * (place - 1.0))
        return _level(across(forward, left), self.speed)


@dataclass(frozen=True)
class DoubleLaneChange(AtWill):
    """Double lane change through lanes of cones."""

    speed: Annotated[float, "m/s", POSITIVE] = 80.0 / 3.6
    offset: Annotated[float, "m", ANY] = 3.5
    entry: Annotated[float, "m", POSITIVE] = 15.0
    over: Annotated[float, "m", POSITIVE] = 30.0
    aside: Annotated[float, "m", POSITIVE] = 25.0
    back: Annotated[float, "m", POSITIVE] = 25.0
    leaving: Annotated[float, "m", POSITIVE] = 30.0
    cut: Annotated[float, "m", NOT_NEGATIVE] = 10.0
    approach: Annotated[float, "m", POSITIVE] = 60.0

    @cached_property
    def way(self) -> Way:
        away = self.approach + self.entry
        home = away + self.over + self.aside
        forward = np.arange(0.0, home + self.back + self.leaving + self.approach, _POINT)
        left = self._changed(forward - away, self.over) - self._changed(forward - home, self.back)
        return _level(across(forward, left), self.speed)

    def _changed(self, place: np.ndarray, length: float) -> np.ndarray:
        return self.offset * _step((place + self.cut) / (length + 2.0 * self.cut))


@dataclass(frozen=True)
class SteadyCircle(AtWill):
    """Circle with slowly rising speed; the constant-radius test of ISO 4138."""

    radius: Annotated[float, "m", ANY] = 100.0
    first_speed: Annotated[float, "m/s", POSITIVE] = 5.0
    last_speed: Annotated[float, "m/s", POSITIVE] = 25.0
    rise: Annotated[float, "m/s**2", POSITIVE] = 0.15
    settle: Annotated[float, "s", NOT_NEGATIVE] = 20.0
    hold: Annotated[float, "s", NOT_NEGATIVE] = 5.0
    entry: Annotated[float, "m", POSITIVE] = 30.0

    def __post_init__(self) -> None:
        require_rise(self.first_speed, self.last_speed)
        if self.radius == 0.0:
            raise ParameterError("a circle of radius 0 cannot be driven; give a radius, positive to the left")

    @property
    def duration(self) -> float:
        return self.settle + (self.last_speed - self.first_speed) / self.rise + self.hold

    @cached_property
    def plan(self) -> Plan:
        time = np.arange(0.0, self.duration + TICK, TICK)
        until = (self.last_speed - self.first_speed) / self.rise
        rising = np.clip(time - self.settle, 0.0, until)
        speed = self.first_speed + self.rise * rising
        distance = self.first_speed * time + 0.5 * self.rise * rising**2
        distance += self.rise * until * np.maximum(time - self.settle - until, 0.0)
        return Plan(distance, speed, self.rise * ((rising > 0.0) & (rising < until)))

    @cached_property
    def way(self) -> Way:
        distance = np.arange(0.0, self.plan.distance[-1] + 50.0, STEP)
        return _level(_step(distance / self.entry - 1.0) / self.radius, self.last_speed)


def _level(curvature: np.ndarray, speed: float) -> Way:
    return Way(curvature, np.full(len(curvature), speed), np.full(len(curvature), math.inf))


def _step(share: np.ndarray) -> np.ndarray:
    share = np.clip(share, 0.0, 1.0)
    return share**3 * (10.0 + share * (6.0 * share - 15.0))
