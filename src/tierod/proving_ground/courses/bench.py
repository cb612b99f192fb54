"""Tests on benches for steering columns and motors: torques over time, no road."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.proving_ground.courses.base import Described
from tierod.proving_ground.courses.course import Columns, Start

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class BenchTorque(Described):
    """Base of the tests in which the motor alone drives; a kind of test gives its `torque_at`.

    Args:
        amplitude: of the motor's torque at its shaft
        settle: at rest before the test
        time: of the whole
        wheel: locked, free, or held by hands without stiffness, of which a motor alone knows nothing
        gear_torque: constant, on the output of the gear, as from a road; of a column alone
    """

    amplitude: Annotated[float, "N*m", NOT_NEGATIVE] = 0.3
    settle: Annotated[float, "s", NOT_NEGATIVE] = 1.0
    time: Annotated[float, "s", POSITIVE] = 61.0
    wheel: Literal["free", "locked", "held"] = "free"
    gear_torque: Annotated[float, "N*m"] = 0.0

    def __post_init__(self):
        if not self.settle < self.time:
            raise ParameterError(
                f"a test of {self.time:g} s ends before it has settled for {self.settle:g} s; give it more time"
            )

    @property
    def duration(self) -> float:
        """Of the whole [s]."""
        return self.time

    @property
    def start(self) -> Start:
        """At rest."""
        return Start()

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        """Of the motor [N m], at times since the settling [s]."""
        raise NotImplementedError

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
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
    """The motor sweeps through frequencies; a longer run sweeps more slowly.

    Args:
        lowest, highest: frequencies; every octave takes the same time
    """

    lowest: Annotated[float, "Hz", POSITIVE] = 0.2
    highest: Annotated[float, "Hz", POSITIVE] = 30.0

    def __post_init__(self):
        super().__post_init__()
        if not self.lowest < self.highest:
            raise ParameterError(
                f"a sweep from {self.lowest:g} to {self.highest:g} Hz has no band; give the lower one first"
            )

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        """A sine of rising frequency."""
        pace = math.log2(self.highest / self.lowest) / (self.time - self.settle)
        cycles = self.lowest * np.expm1(math.log(2.0) * pace * since) / (math.log(2.0) * pace)
        return self.amplitude * np.sin(2.0 * math.pi * cycles)


@dataclass(frozen=True)
class BenchRamps(BenchTorque):
    """Slow ramps of the motor's torque to and fro, from small ones on: friction builds up, slides, and turns back.

    Args:
        period: of a ramp to and fro
        first: share of the amplitude that the first ramps have
    """

    period: Annotated[float, "s", POSITIVE] = 4.0
    first: Annotated[float, "", SHARE] = 0.5

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        """A triangle that grows."""
        triangle = 2.0 / math.pi * np.arcsin(np.sin(2.0 * math.pi * since / self.period))
        return self.amplitude * triangle * (self.first + (1.0 - self.first) * since / (self.time - self.settle))


@dataclass(frozen=True)
class BenchSteps(BenchTorque):
    """Steps of the motor's torque between left, nothing and right.

    Args:
        hold: of each level
    """

    hold: Annotated[float, "s", POSITIVE] = 0.5

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        """Left, nothing, right, nothing, and so on."""
        return self.amplitude * np.array([1.0, 0.0, -1.0, 0.0])[np.floor(since / self.hold).astype(int) % 4]


@dataclass(frozen=True)
class BenchMultisine(BenchTorque):
    """Sines of one size at frequencies of one ratio to the next, with phases that keep their sum low.

    Args:
        lowest, highest: frequencies
        count: of the sines
    """

    lowest: Annotated[float, "Hz", POSITIVE] = 0.25
    highest: Annotated[float, "Hz", POSITIVE] = 20.0
    count: Annotated[int, "", COUNT] = 16

    def torque_at(self, since: np.ndarray) -> np.ndarray:
        """Their sum, of the power of one sine of the amplitude; its peak is about three times its mean size."""
        number = np.arange(self.count)
        frequency = np.geomspace(self.lowest, self.highest, self.count)
        phase = 2.0 * math.pi * _GOLDEN * number**2
        sines = np.sin(2.0 * math.pi * np.outer(since, frequency) + phase)
        return self.amplitude * math.sqrt(1.0 / self.count) * sines.sum(axis=1)
