"""Keeps the signals of the last moments, for the freeze frames of failures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tierod.diagnosis.entry import FreezeFrame

BEFORE, AFTER = 2.0, 1.0
"""What a freeze frame shows around the instant of the failure [s]."""

MOST = 61
"""Values per signal in a frame."""


class Window:
    """Signals of the last moments."""

    def __init__(self) -> None:
        self.time = np.zeros(0)
        self.values: dict[str, np.ndarray] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """More samples, later than those before; a signal that a piece lacks is missing there."""
        old, new = len(self.time), len(time)
        self.time = np.concatenate([self.time, time])
        for name in {**self.values, **signals}:
            before = self.values.get(name, np.full(old, np.nan))
            self.values[name] = np.concatenate([before, signals.get(name, np.full(new, np.nan))])

    def forget(self, until: float) -> None:
        """Drop what lies before a time [s]."""
        first = int(np.searchsorted(self.time, until))
        self.time = self.time[first:]
        self.values = {name: values[first:] for name, values in self.values.items()}

    def frame(self, cycle: int, date: str, instant: float) -> FreezeFrame:
        """What is held of the signals around an instant [s], thinned out so that the instant stays."""
        begin = int(np.searchsorted(self.time, instant - BEFORE))
        end = int(np.searchsorted(self.time, instant + AFTER, "right"))
        centre = max(int(np.searchsorted(self.time, instant + 1e-9)) - 1, begin)
        stride = max(-(-(end - begin) // MOST), 1)
        kept = np.arange(begin + (centre - begin) % stride, end, stride)
        values = {
            name: tuple(float(value) if np.isfinite(value) else None for value in each[kept])
            for name, each in self.values.items()
        }
        return FreezeFrame(cycle, date, instant, tuple(np.round(self.time[kept] - instant, 6).tolist()), values)
