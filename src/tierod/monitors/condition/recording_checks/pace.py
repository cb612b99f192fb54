"""How often what is asked of the actuators is recorded: between two targets the cause of a motion is unknown."""

from __future__ import annotations

import numpy as np

from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.recording_checks.coverage import LOST
from tierod.monitors.condition.signals import TARGETS, ConditionSample

SLOWEST = 40.0
"""Rate of a target below which nothing is judged [Hz].

Ten minutes of a calibrated demonstrator, whose control works at 100 Hz, are sound with targets read at 50 Hz; at 33 Hz
the sound sensor of the steering torque would be called faulty for 90 s of them. Sensors may come at 20 Hz.
"""

_PLACES = [ConditionSample._fields.index(name) for name in TARGETS]


class TargetPace:
    """Follows how far the readings of each target are apart, piece by piece; longer silence is a loss and counts not.

    Args:
        rate: of the samples [Hz]
    """

    def __init__(self, rate: float):
        self._rate = rate
        self._age = np.full(len(TARGETS), np.inf)
        self._apart, self._count = np.zeros(len(TARGETS)), np.zeros(len(TARGETS))

    def add(self, values: np.ndarray) -> None:
        """The next piece, columns of `ConditionSample`, (n, signals); NaN where missing."""
        for place, column in enumerate(_PLACES):
            there = np.flatnonzero(np.isfinite(values[:, column]))
            apart = np.diff(np.concatenate(([-self._age[place]], there)))
            apart = apart[apart <= LOST * self._rate]
            self._apart[place] += apart.sum()
            self._count[place] += len(apart)
            self._age[place] = len(values) - there[-1] if len(there) else self._age[place] + len(values)

    def problems(self) -> tuple[Problem, ...]:
        """That targets come too seldom, if they do."""
        rates = self._rate * self._count / np.maximum(self._apart, 1.0)
        slow = [name for name, rate, count in zip(TARGETS, rates, self._count, strict=True) if count and rate < SLOWEST]
        if not slow:
            return ()
        rate = min(rates[TARGETS.index(name)] for name in slow)
        which = "targets of the actuators come" if len(slow) > 1 else f"{slow[0]} comes"
        cause = f"the {which} at {rate:.3g} Hz: what moves the vehicle in between is not known"
        return (Problem("rate", (), cause, f"record {', '.join(slow)} at 50 Hz or faster"),)
