"""Tests on benches for steering columns and motors: torques of motor and hands over time, without a road."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE, SHARE
from tierod_lab.ground.courses.course import Acting, Columns, Repeated, Start, Tremor, smooth_noise
from tierod_lab.ground.courses.way import Described

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Golden ratio: phases of this ratio times the squared number of a sine keep the peak of a multisine low."""


@dataclass(frozen=True)
class BenchTorque(Described):
    """Base class of the tests that are driven by the motor alone; each kind of test defines its `torque_at`."""

    amplitude: Annotated[float, "N*m", NOT_NEGATIVE] = 0.3
    settle: Annotated[float, "s", NOT_NEGATIVE] = 1.0
    time: Annotated[float, "s", POSITIVE] = 61.0
    # locked, free, or held by hands without stiffness; for a motor bench, `locked` locks the shaft, and `held` is not
    # possible
    wheel: Literal["free", "locked", "held"] = "free"
    # constant torque on the output of the gear, as from a road; for column benches only
    gear_torque: Annotated[float, "N*m"] = 0.0

    def __post_init__(self) -> None:
        if not self.settle < self.time:
            raise ParameterError(
                f"a test of {self.time:g} s ends before it has settled for {self.settle:g} s; give it more time"
            )

    @property
    def duration(self) -> float:
        return self.time

    @property
    def start(self) -> Start:
        return Start()

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        raise NotImplementedError

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        since = np.clip(time - self.settle, 0.0, self.time - self.settle)
        constant = np.ones(len(time))
        columns = {
            "motor_torque": np.where(time < self.settle, 0.0, self.torque_at(since)),
            "locked": float(self.wheel == "locked") * constant,
        }
        if self.gear_torque != 0.0:
            columns["gear_torque"] = self.gear_torque * constant
        if self.wheel == "held":
            columns["grip"] = constant
        return self._with_conditions(columns, time, distance)


@dataclass(frozen=True)
class BenchSweep(BenchTorque):
    """Sine sweep of the motor torque; a longer run sweeps more slowly."""

    # lowest, highest: first and last frequency; every octave takes the same time
    lowest: Annotated[float, "Hz", POSITIVE] = 0.2
    highest: Annotated[float, "Hz", POSITIVE] = 30.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.lowest < self.highest:
            raise ParameterError(
                f"a sweep from {self.lowest:g} to {self.highest:g} Hz has no band; give the lower one first"
            )

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        pace = math.log2(self.highest / self.lowest) / (self.time - self.settle)
        cycles = self.lowest * np.expm1(math.log(2.0) * pace * since) / (math.log(2.0) * pace)
        return self.amplitude * np.sin(2.0 * math.pi * cycles)


@dataclass(frozen=True)
class BenchRamps(BenchTorque):
    """Slow triangular ramps of the motor torque with growing amplitude: friction builds up, slides and reverses."""

    period: Annotated[float, "s", POSITIVE] = 4.0
    first: Annotated[float, "", SHARE] = 0.5

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        triangle = 2.0 / math.pi * np.arcsin(np.sin(2.0 * math.pi * since / self.period))
        return self.amplitude * triangle * (self.first + (1.0 - self.first) * since / (self.time - self.settle))


@dataclass(frozen=True)
class BenchSteps(BenchTorque):
    """Steps of the motor torque between left, zero and right."""

    hold: Annotated[float, "s", POSITIVE] = 0.5

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        return np.asarray(self.amplitude * np.array([1.0, 0.0, -1.0, 0.0])[np.floor(since / self.hold).astype(int) % 4])


@dataclass(frozen=True)
class BenchMultisine(BenchTorque):
    """Multisine of equal amplitudes at geometrically spaced frequencies, with phases for a low peak."""

    lowest: Annotated[float, "Hz", POSITIVE] = 0.25
    highest: Annotated[float, "Hz", POSITIVE] = 20.0
    count: Annotated[int, "", COUNT] = 16

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        number = np.arange(self.count)
        frequency = np.geomspace(self.lowest, self.highest, self.count)
        phase = 2.0 * math.pi * _GOLDEN * number**2
        sines = np.sin(2.0 * math.pi * np.outer(since, frequency) + phase)
        return np.asarray(self.amplitude * math.sqrt(1.0 / self.count) * sines.sum(axis=1))


STRETCH = (20.0, 60.0)  # Minimum and maximum time for which the motor repeats the same action [s]
_EPISODES, _TORQUE, _STRETCHES, _LANE = 10, 11, 12, 13


@dataclass(frozen=True)
class BenchHands(Described):
    """Hands on and off at random times, with light or firm grip and a random torque, while the motor works.

    The motor alternates between three actions: no torque, small random torques as of a lane keeping assistant, and
    sines.
    """

    time: Annotated[float, "s", POSITIVE] = 600.0
    # shortest, longest: range of the times with hands on, or off; log-uniform
    shortest: Annotated[float, "s", POSITIVE] = 3.0
    longest: Annotated[float, "s", POSITIVE] = 20.0
    # lightest, firmest: range of the standard deviation of the hand torque of one hold; log-uniform
    lightest: Annotated[float, "N*m", NOT_NEGATIVE] = 0.1
    firmest: Annotated[float, "N*m", NOT_NEGATIVE] = 0.5
    quickest: Annotated[float, "s", POSITIVE] = 0.05
    slowest: Annotated[float, "s", POSITIVE] = 0.4
    tremor: Annotated[float, "N*m", NOT_NEGATIVE] = 0.03
    ramp: Annotated[float, "s", POSITIVE] = 0.03
    lane_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.2
    sweep_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.6

    def __post_init__(self) -> None:
        for low, high in (("shortest", "longest"), ("lightest", "firmest"), ("quickest", "slowest")):
            least, most = getattr(self, low), getattr(self, high)
            if not least <= most:
                raise ParameterError(f"{low} is {least:g} and {high} {most:g}; the first must not be greater")
        if not 2.0 * self.ramp <= self.shortest:
            hurried = f"hands that stay {self.shortest:g} s cannot take {self.ramp:g} s each for gripping and releasing"
            raise ParameterError(f"{hurried}; give at least twice the ramp")

    @property
    def duration(self) -> float:
        return self.time

    @property
    def start(self) -> Start:
        return Start()

    @cached_property
    def switches(self) -> np.ndarray:
        """Times at which hands arrive (even indices) and leave (odd indices) [s]; initially off."""
        return np.cumsum(_drawn(self.generator(_EPISODES), self.shortest, self.longest, self.time))

    @cached_property
    def firmness(self) -> np.ndarray:
        """Standard deviation of the torque [N*m], and grip [-], of every hold, (n, 2)."""
        draw, count = self.generator(_TORQUE), len(self.switches) // 2 + 1
        torque = self.lightest * (self.firmest / max(self.lightest, 1e-12)) ** draw.random(count)
        return np.column_stack([torque, draw.uniform(0.5, 1.0, count)])

    @cached_property
    def _hand_torque(self) -> Repeated:
        step = 0.2 * self.quickest
        return Repeated(smooth_noise(self.generator(_TORQUE, 1), self.quickest, self.slowest, step), step)

    @cached_property
    def _trembling(self) -> Acting:
        return Tremor(deviation=self.tremor).acting(self.generator(_TORQUE, 2))

    @cached_property
    def _lane_torque(self) -> Repeated:
        return Repeated(smooth_noise(self.generator(_LANE), 0.3, 1.5, 0.05), 0.05)

    @cached_property
    def _stretches(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Start of every stretch [s], action of the motor, and relative amplitude and frequency [Hz] of its sines."""
        draw = self.generator(_STRETCHES)
        starts = np.concatenate([[0.0], np.cumsum(_drawn(draw, *STRETCH, self.time))])
        kind = draw.permuted(np.tile([0, 1, 2], (len(starts) // 3 + 1, 1)), axis=1).ravel()[: len(starts)]
        shape = np.column_stack([draw.uniform(0.3, 1.0, len(starts)), 0.2 * 15.0 ** draw.random(len(starts))])
        return starts, kind, shape

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        present, hold = self.held(time)
        torque, grip = self.firmness[hold].T
        trembling = self._trembling(time, distance)["demand.hand_torque"]
        columns = {
            "motor_torque": self._motor(time),
            "grip": present * grip,
            "hand_torque": present * (torque * self._hand_torque.at(time) + trembling),
        }
        return self._with_conditions(columns, time, distance)

    def held(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Share of the hands' grip, 0 to 1, and number of the hold, at some instants [s]."""
        place = np.searchsorted(self.switches, time, side="right")
        since = time - self.switches[np.maximum(place - 1, 0)]
        faded = np.clip(since / self.ramp, 0.0, 1.0)
        faded = faded * faded * (3.0 - 2.0 * faded)
        present = np.where(place % 2 == 1, faded, np.where(place == 0, 0.0, 1.0 - faded))
        return present, np.maximum(place - 1, 0) // 2

    def _motor(self, time: np.ndarray) -> np.ndarray:
        starts, kind, shape = self._stretches
        place = np.searchsorted(starts, time, side="right") - 1
        amplitude, frequency = shape[place].T
        since = time - starts[place]
        fade = np.clip(since, 0.0, 1.0)
        sine = self.sweep_torque * amplitude * np.sin(2.0 * math.pi * frequency * since)
        lane = self.lane_torque * self._lane_torque.at(time)
        return np.asarray(fade * np.choose(kind[place], [np.zeros(len(time)), lane, sine]))


def _drawn(generator: np.random.Generator, shortest: float, longest: float, time: float) -> np.ndarray:
    """Log-uniform random durations between two bounds, as many as fill a time [s]."""
    count = int(time / shortest) + 2
    drawn = shortest * (longest / shortest) ** generator.random(count)
    return drawn[: int(np.searchsorted(np.cumsum(drawn), time)) + 1]
