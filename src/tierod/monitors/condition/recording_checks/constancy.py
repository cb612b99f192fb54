"""Sensors whose readings stay exactly the same while the vehicle moves, far longer than at any other time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tierod.core.findings import Status
from tierod.monitors.condition.recording_checks.absence import Loss

LONG = 5.0
"""Time of driving for which a reading must stay the same [s]; coarse angles on straight roads reach 3 s."""
UNUSUAL = 4.0
"""Ratio of that time to the next longest one of the same sensor [-]: a coarse sensor repeats itself often."""


class Constancy:
    """Follows piece by piece for how long each reading stays exactly the same; standstill and gaps do not count.

    A sensor that fails to a plausible value, such as a yaw rate of zero on a straight road, contradicts no other.

    Args:
        names: names of the sensors
        period: sampling interval [s]
    """

    def __init__(self, names: tuple[str, ...], period: float):
        self._names, self._period = names, period
        self._last = np.full(len(names), np.nan)
        self._begun, self._end = np.full(len(names), np.nan), np.full(len(names), np.nan)
        self._count = np.zeros(len(names), int)
        self._longest: list[tuple[int, float, float]] = [(0, 0.0, 0.0)] * len(names)
        self._second = np.zeros(len(names), int)

    def add(self, time: np.ndarray, readings: np.ndarray, moving: np.ndarray) -> None:
        """Add the next piece: time [s], (n,); readings, (n, sensors); whether the vehicle moves, (n,)."""
        for place in range(len(self._names)):
            counts = np.flatnonzero(np.isfinite(readings[:, place]) & moving)
            if len(counts):
                self._follow(place, time[counts], readings[counts, place])

    def _follow(self, place: int, time: np.ndarray, values: np.ndarray) -> None:
        changes = np.flatnonzero(np.diff(values, prepend=self._last[place]) != 0.0)
        edges = [0, *changes.tolist(), len(values)]
        for first, (start, stop) in enumerate(pairwise(edges)):
            if first:
                self._close(place)
                self._begun[place], self._count[place] = time[start], 0
            if stop > start:
                self._count[place] += stop - start
                self._end[place] = time[stop - 1]
        self._last[place] = values[-1]

    def _close(self, place: int) -> None:
        """Count the run that has ended."""
        run = int(self._count[place]), float(self._begun[place]), float(self._end[place])
        if run[0] > self._longest[place][0]:
            self._second[place], self._longest[place] = self._longest[place][0], run
        else:
            self._second[place] = max(self._second[place], run[0])

    def losses(self) -> dict[str, Loss]:
        """Sensors whose reading stayed the same for unusually long, with the time."""
        found = {}
        for place, name in enumerate(self._names):
            now = int(self._count[place]), float(self._begun[place]), float(self._end[place])
            (count, start, end), *others = sorted((self._longest[place], now), reverse=True)
            second = max(int(self._second[place]), others[0][0])
            if count * self._period >= LONG and count > UNUSUAL * second > 0.0:
                cause = f"its reading stayed the same from {start:.2f} s to {end:.2f} s of driving"
                found[name] = Loss(Status.NOT_TESTABLE, cause, start)
        return found
