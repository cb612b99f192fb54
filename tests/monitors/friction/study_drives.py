"""Drives of the friction study, named by what the tests of the monitors vary."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tierod.core.recording import Recording
from tierod.monitors.friction.signals import SteeringSample
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction import cases

MINUTES = 7.0
"""Duration of a drive [min]."""


@dataclass(frozen=True)
class Case:
    """One drive of the study.

    Args:
        seed: of route, driver, sensors, and of the car where it is drawn
        level: of friction [N*m], before the change if there is one
        changed_level: level from half-time on [N*m]; None for no change
        dahl_angle: of the friction [rad]; 0.01 degrees is Coulomb friction
        law: of the friction, "Dahl" or a name of the study
        rate_noise: of the steering wheel rate [rad/s]
        scatter: "none", or a name of the study
        minutes: duration [min]
    """

    seed: int
    level: float = 4.0
    changed_level: float | None = None
    dahl_angle: float = math.radians(1.0)
    law: str = "Dahl"
    rate_noise: float = 0.01
    scatter: str = "none"
    minutes: float = MINUTES

    def recording(self) -> Recording:
        """The drive as sensors see it."""
        degrees = round(math.degrees(self.dahl_angle), 2)
        dahl = "Coulomb" if degrees == 0.01 else f"Dahl {degrees:g}°"
        course = self.level
        if self.changed_level is not None:
            course = FrictionCourse.step(self.level, self.changed_level, at=30.0 * self.minutes)
        drawn = self.scatter != "none"
        return cases.Case(
            self.seed,
            course,
            self.minutes,
            car=self.seed if drawn else None,
            scatter=self.scatter if drawn else "usual",
            law=dahl if self.law == "Dahl" else self.law,
            condition="as usual" if self.rate_noise == 0.01 else f"rate noise {self.rate_noise:g} rad/s",
        ).recording()


@lru_cache(maxsize=32)
def signals(case: Case) -> np.ndarray:
    """What the monitor takes of a drive, at 100 Hz; to be copied before it is changed."""
    return case.recording().align(SteeringSample._fields, 100.0).values
