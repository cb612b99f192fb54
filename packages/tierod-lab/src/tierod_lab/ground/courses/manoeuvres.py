"""Tests along a lane, and open-loop tests: a steering-wheel angle over time at a given speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod_lab.ground.courses.course import Columns, band_limited, combine
from tierod_lab.ground.courses.way import (
    STEP,
    TICK,
    Plan,
    TimeCourse,
    Way,
    WayCourse,
    across,
    require_rise,
    require_some,
)

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


@dataclass(frozen=True)
class AtSpeed(TimeCourse):
    """Base class of the tests at one speed."""

    speed: Annotated[float, "m/s", NOT_NEGATIVE] = 100.0 / 3.6
    settle: Annotated[float, "s", NOT_NEGATIVE] = 3.0
    rest: Annotated[float, "s", NOT_NEGATIVE] = 3.0

    @property
    def test_time(self) -> float:
        raise NotImplementedError

    @property
    def duration(self) -> float:
        return self.settle + self.test_time + self.rest

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full(len(time), self.speed), np.zeros(len(time))


@dataclass(frozen=True)
class AngleRamp(AtSpeed):
    """Slow ramp of the steering-wheel angle at one speed; the constant-speed test of ISO 4138."""

    angle: Annotated[float, "rad", ANY] = math.radians(100.0)
    rate: Annotated[float, "rad/s", POSITIVE] = math.radians(4.0)

    @property
    def test_time(self) -> float:
        return abs(self.angle) / self.rate

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        turned = np.minimum(np.maximum(time - self.settle, 0.0) * self.rate, abs(self.angle))
        return np.asarray(math.copysign(1.0, self.angle) * turned)


@dataclass(frozen=True)
class StepSteer(AngleRamp):
    """Step of the steering-wheel angle, which is then held; ISO 7401."""

    angle: Annotated[float, "rad", ANY] = math.radians(40.0)
    rate: Annotated[float, "rad/s", POSITIVE] = math.radians(400.0)
    hold: Annotated[float, "s", POSITIVE] = 5.0

    @property
    def test_time(self) -> float:
        return super().test_time + self.hold


@dataclass(frozen=True)
class SineSteer(AtSpeed):
    """Sine steering: one or more periods (ISO 7401), the on-centre weave test (ISO 13674-1), or sine with dwell."""

    amplitude: Annotated[float, "rad", ANY] = math.radians(30.0)
    frequency: Annotated[float, "Hz", POSITIVE] = 0.5
    periods: int = 1
    dwell: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def __post_init__(self) -> None:
        require_some("periods", self.periods)

    @property
    def test_time(self) -> float:
        return self.periods / self.frequency + self.dwell

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        phase = (time - self.settle) * self.frequency
        extreme = self.periods - 0.25
        phase = np.where(phase > extreme, np.maximum(phase - self.dwell * self.frequency, extreme), phase)
        return self.amplitude * np.sin(2.0 * math.pi * np.minimum(np.maximum(phase, 0.0), self.periods))


@dataclass(frozen=True)
class RandomSteer(AtSpeed):
    """Random steering within a frequency band; ISO 7401."""

    deviation: Annotated[float, "rad", NOT_NEGATIVE] = math.radians(10.0)
    lowest: Annotated[float, "Hz", POSITIVE] = 0.2
    highest: Annotated[float, "Hz", POSITIVE] = 2.0
    time: Annotated[float, "s", POSITIVE] = 60.0

    def __post_init__(self) -> None:
        if not (self.highest - self.lowest) * self.time >= 1.0:
            band = f"random steering from {self.lowest:g} to {self.highest:g} Hz has no band that {self.time:g} s"
            raise ParameterError(f"{band} could show; give the lower one first, and more time for a narrower band")

    @property
    def test_time(self) -> float:
        return self.time

    @cached_property
    def _curve(self) -> tuple[np.ndarray, np.ndarray]:
        step = 0.02 / self.highest
        curve = band_limited(self.generator(0), self.lowest, self.highest, self.time, step)
        time = np.arange(len(curve)) * step
        fade = np.clip(np.minimum(time, self.time - time), 0.0, 1.0)
        return self.settle + time, self.deviation * fade * curve

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        return np.asarray(np.interp(time, *self._curve, left=0.0, right=0.0))


@dataclass(frozen=True)
class SteadyAngle(TimeCourse):
    """Constant steering-wheel angle with slowly rising speed; the constant-angle test of ISO 4138."""

    angle: Annotated[float, "rad", ANY] = math.radians(30.0)
    turning: Annotated[float, "s", POSITIVE] = 3.0
    first_speed: Annotated[float, "m/s", POSITIVE] = 5.0
    last_speed: Annotated[float, "m/s", POSITIVE] = 30.0
    rise: Annotated[float, "m/s**2", POSITIVE] = 0.2
    settle: Annotated[float, "s", POSITIVE] = 10.0

    def __post_init__(self) -> None:
        require_rise(self.first_speed, self.last_speed)

    @property
    def duration(self) -> float:
        return self.settle + (self.last_speed - self.first_speed) / self.rise

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rising = (time > self.settle) & (time < self.duration)
        passed = np.minimum(np.maximum(time, self.settle), self.duration) - self.settle
        return self.first_speed + self.rise * passed, self.rise * rising

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        share = np.minimum(time / self.turning, 1.0)
        return self.angle * (0.5 - 0.5 * np.cos(math.pi * share))


@dataclass(frozen=True)
class LockToLock(TimeCourse):
    """Slow turn of the standing car from the middle to the right lock, to the left one, and back.

    Each stroke is half a cosine, preceded by a rest.
    Source: Mohtat et al., Appendix A: 0, -570, +570, 0 degrees.
    """

    lock_angle: Annotated[float, "rad", POSITIVE] = math.radians(570.0)
    rate: Annotated[float, "rad/s", POSITIVE] = 1.0
    rest: Annotated[float, "s", POSITIVE] = 2.0
    load: Annotated[float, "", SHARE] = 1.0

    @cached_property
    def _strokes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angles between the strokes [rad], and start and end of every stroke [s]."""
        targets = self.lock_angle * np.array([0.0, -1.0, 1.0, 0.0])
        turning = 0.5 * math.pi * np.abs(np.diff(targets)) / self.rate
        ends = np.cumsum(turning + self.rest)
        return targets, ends - turning, ends

    @property
    def duration(self) -> float:
        return float(self._strokes[2][-1] + self.rest)

    def speed_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(len(time)), np.zeros(len(time))

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        targets, starts, ends = self._strokes
        stroke = np.minimum(np.searchsorted(ends, time), len(ends) - 1)
        share = np.clip((time - starts[stroke]) / (ends - starts)[stroke], 0.0, 1.0)
        eased = 0.5 - 0.5 * np.cos(math.pi * share)
        return np.asarray(targets[stroke] + (targets[stroke + 1] - targets[stroke]) * eased)

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        columns = super().columns(time, distance, speed, ahead)
        combine(columns, {"road.support": np.full(len(time), self.load)})
        return columns
