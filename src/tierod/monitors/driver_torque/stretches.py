"""For how long hands were off the wheel at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.monitors.driver_torque.hands import OFF


class Stretch(NamedTuple):
    """Hands off the wheel: since when [s], and for how long [s]."""

    start: float
    duration: float


class Stretches:
    """Stretches without hands over the pieces of a recording.

    Args:
        sample_time: between two samples [s]
    """

    def __init__(self, sample_time: float):
        self._sample_time = sample_time
        self._ended: list[Stretch] = []
        self._begun: float | None = None
        self._last = 0.0

    def add(self, time: np.ndarray, hands: np.ndarray) -> None:
        """The next piece: time [s] and codes of the state, (n,) each."""
        off = hands == OFF
        changes = np.flatnonzero(np.diff(off, prepend=self._begun is not None))
        for at in changes.tolist():
            if off[at]:
                self._begun = float(time[at])
            elif self._begun is not None:
                self._ended.append(Stretch(self._begun, float(time[at]) - self._begun))
                self._begun = None
        self._last = float(time[-1])

    def found(self) -> list[Stretch]:
        """All stretches, the one that lasts until the end among them."""
        if self._begun is None:
            return self._ended
        return [*self._ended, Stretch(self._begun, self._last + self._sample_time - self._begun)]
