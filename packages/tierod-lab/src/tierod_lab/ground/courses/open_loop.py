"""Open-loop tests: a steering-wheel angle over time at a given speed, without a lane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod_lab.ground.courses.base import TimeCourse, require_rise, require_some
from tierod_lab.ground.courses.course import Columns, band_limited, combine


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
class StepSteer(AtSpeed):
    """Step of the steering-wheel angle, which is then held; ISO 7401."""

    angle: Annotated[float, "rad", ANY] = math.radians(40.0)
    rate: Annotated[float, "rad/s", POSITIVE] = math.radians(400.0)
    hold: Annotated[float, "s", POSITIVE] = 5.0

    @property
    def test_time(self) -> float:
        return abs(self.angle) / self.rate + self.hold

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        return _turned(time - self.settle, self.angle, self.rate)


def _turned(since: np.ndarray, angle: float, rate: float) -> np.ndarray:
    """Angle that moves from zero to an end at a rate [rad]."""
    return np.asarray(math.copysign(1.0, angle) * np.minimum(np.maximum(since, 0.0) * rate, abs(angle)))


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
            raise ParameterError(
                f"random steering from {self.lowest:g} to {self.highest:g} Hz has no band that {self.time:g} s could "
                "show; give the lower one first, and more time the narrower the band is"
            )

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
class AngleRamp(AtSpeed):
    """Slow ramp of the steering-wheel angle at one speed; the constant-speed test of ISO 4138."""

    angle: Annotated[float, "rad", ANY] = math.radians(100.0)
    rate: Annotated[float, "rad/s", POSITIVE] = math.radians(4.0)

    @property
    def test_time(self) -> float:
        return abs(self.angle) / self.rate

    def angle_at(self, time: np.ndarray) -> np.ndarray:
        return _turned(time - self.settle, self.angle, self.rate)


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
        return np.asarray(
            targets[stroke] + (targets[stroke + 1] - targets[stroke]) * (0.5 - 0.5 * np.cos(math.pi * share))
        )

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        columns = super().columns(time, distance, speed, ahead)
        combine(columns, {"road.support": np.full(len(time), self.load)})
        return columns
