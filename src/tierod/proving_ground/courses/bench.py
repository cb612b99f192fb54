"""Tests on benches for steering columns and motors: torques over time, no road."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from tierod.errors import ParameterError
from tierod.proving_ground.courses.base import Described
from tierod.proving_ground.courses.course import Columns, Start
from tierod.ranges import NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class BenchSweep(Described):
    """The motor sweeps through frequencies while the steering wheel (or the motor's shaft) is free, locked or held.

    Args:
        amplitude: of the motor's torque at its shaft
        lowest, highest: frequencies; every octave takes the same time
        settle: at rest before the sweep
        time: of the whole; a longer run sweeps more slowly
        wheel: locked, free, or held by hands without stiffness, of which a motor alone knows nothing
        gear_torque: constant, on the output of the gear, as from a road; of a column alone
    """

    amplitude: Annotated[float, "N*m", NOT_NEGATIVE] = 0.3
    lowest: Annotated[float, "Hz", POSITIVE] = 0.2
    highest: Annotated[float, "Hz", POSITIVE] = 30.0
    settle: Annotated[float, "s", NOT_NEGATIVE] = 1.0
    time: Annotated[float, "s", POSITIVE] = 61.0
    wheel: Literal["free", "locked", "held"] = "free"
    gear_torque: Annotated[float, "N*m"] = 0.0

    def __post_init__(self):
        if not self.lowest < self.highest:
            raise ParameterError(
                f"a sweep from {self.lowest:g} to {self.highest:g} Hz has no band; give the lower one first"
            )
        if not self.settle < self.time:
            raise ParameterError(
                f"a sweep of {self.time:g} s ends before it has settled for {self.settle:g} s; give it more time"
            )

    @property
    def duration(self) -> float:
        """Of the whole [s]."""
        return self.time

    @property
    def start(self) -> Start:
        """At rest."""
        return Start()

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
        octaves = math.log2(self.highest / self.lowest)
        pace = octaves / (self.time - self.settle)
        since = np.clip(time - self.settle, 0.0, self.time - self.settle)
        cycles = self.lowest * np.expm1(math.log(2.0) * pace * since) / (math.log(2.0) * pace)
        constant = np.ones(len(time))
        columns = {
            "motor_torque": self.amplitude * np.sin(2.0 * math.pi * cycles),
            "locked": float(self.wheel == "locked") * constant,
        }
        if self.gear_torque != 0.0:
            columns["gear_torque"] = self.gear_torque * constant
        if self.wheel == "held":
            columns["grip"] = constant
        return self._with_conditions(columns, time, distance)
