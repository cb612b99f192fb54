"""Figures over the pieces of a drive, beside what is said of sensors and actuators."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from tierod.diagnosis.substitution import SubstitutionGraph
from tierod.graph import Result
from tierod.monitors.condition.coverage import TARGETS, Covered
from tierod.monitors.condition.signals import ACTUATORS, SENSORS

STANDING = 0.5
"""Speed below which the vehicle stands [m/s]."""
NO_READING = "no sensor gives a reading"
ALL_ZERO = "all sensors read exactly zero"


@dataclass
class Driven:
    """Figures over the pieces of a recording.

    Args:
        period: of the samples [s]
        end: of the last one [s]
        samples: all of them
        judged, forward, backward: samples that were judged, and in which the vehicle drove forward and backward
        unjudged: samples that were not, by their cause
        sources: samples in which each sensor was supplied by each source
    """

    period: float
    end: float = math.nan
    samples: int = 0
    judged: int = 0
    forward: int = 0
    backward: int = 0
    unjudged: dict[str, int] = field(default_factory=dict)
    sources: dict[str, dict[str, int]] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        """Of all samples."""
        return self.samples * self.period

    @property
    def not_judged(self) -> str:
        """Why most of what could not be judged could not; "" where all could."""
        return max(self.unjudged, key=lambda cause: self.unjudged[cause]) if self.unjudged else ""

    def add(self, time: np.ndarray, values: np.ndarray, covered: Covered) -> None:
        """The next piece: time [s], columns of `ConditionSample`, and what there is of them."""
        self.end = float(time[-1]) + self.period
        self.samples += len(time)
        self.judged += int(np.count_nonzero(covered.judged))
        with np.errstate(invalid="ignore"):
            self.forward += int(np.count_nonzero((values[:, :2] > STANDING).any(axis=1)))
            self.backward += int(np.count_nonzero((values[:, :2] < -STANDING).any(axis=1)))
        read = covered.available[:, : len(SENSORS)].any(axis=1)
        self._count(ALL_ZERO, ~read & covered.zero)
        self._count(NO_READING, ~read & ~covered.zero)
        for place, actuator in enumerate(ACTUATORS, len(SENSORS)):
            cause = f"what is asked of {actuator.replace('_', ' ')} is not recorded ({TARGETS[place - len(SENSORS)]})"
            self._count(cause, read & ~covered.available[:, place])

    def _count(self, cause: str, there: np.ndarray) -> None:
        found = int(np.count_nonzero(there))
        if found:
            self.unjudged[cause] = self.unjudged.get(cause, 0) + found

    def add_sources(self, supplied: Result, graph: SubstitutionGraph) -> None:
        """Where each sensor's signal came from over the next piece."""
        for sensor, ways in graph.substitutes.items():
            source = supplied[f"{sensor}.source"]
            told = self.sources.setdefault(sensor, {})
            for number, way in enumerate(ways, 1):
                told[way.name] = told.get(way.name, 0) + int(np.count_nonzero(source == number))
