"""Drives of the friction study, named by what the tests of the monitors vary."""

import math
from functools import lru_cache

import numpy as np

from tierod.monitors.friction.signals import SteeringSample
from tierod_lab.ground import FrictionCourse
from tierod_lab.papers.friction import cases


@lru_cache(maxsize=32)
def signals(
    seed: int, level: float = 4.0, changed: float | None = None, dahl: float = 1.0, noise: float = 0.01, minutes=7.0
) -> np.ndarray:
    """What the monitor takes of a drive, at 100 Hz; to be copied before it is changed.

    Args:
        level: friction [N*m], before the change at half-time if there is one, and `changed` after it
        dahl: Dahl angle of the friction [deg]; 0.01 is Coulomb friction
        noise: of the steering wheel rate [rad/s]
        minutes: duration [min]
    """
    course = level if changed is None else FrictionCourse.step(level, changed, at=30.0 * minutes)
    law = "Coulomb" if dahl == 0.01 else f"Dahl {dahl:g}°"
    condition = "as usual" if math.isclose(noise, 0.01) else f"rate noise {noise:g} rad/s"
    case = cases.Case(seed, course, minutes, car=None, scatter="usual", law=law, condition=condition)
    return case.recording().align(SteeringSample._fields, 100.0).values
