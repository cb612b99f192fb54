"""Long time series in bounded memory: lowest, highest and mean value of every bin, so that nothing is hidden."""

from __future__ import annotations

import numpy as np

from tierod.findings import Trace


class Decimator:
    """Collects one signal chunk by chunk; bins double in width as the recording grows.

    Args:
        name: of the signal
        unit: in the notation of pint
        bins: how many bins there are at the least once they are full; at the most twice as many
    """

    def __init__(self, name: str, unit: str, bins: int = 2000):
        self.name, self.unit, self.bins = name, unit, bins
        self._start: float | None = None
        self._width = 0.0
        self._lower = self._upper = self._sum = self._count = np.empty(0)

    def add(self, time: np.ndarray, values: np.ndarray) -> None:
        """Samples that follow those already added.

        Args:
            time: [s], shape (n,), rising
            values: shape (n,); NaN where missing
        """
        if not len(time):
            return
        if self._start is None:
            self._start = float(time[0])
            steps = np.diff(time[:1000])
            steps = steps[steps > 0.0]
            self._width = float(np.median(steps)) if len(steps) else 1.0
        while (time[-1] - self._start) / self._width >= 2 * self.bins:
            self._halve()
        index = np.floor((time - self._start) / self._width + 1e-6).astype(int)
        self._grow(int(index[-1]) + 1)
        seen = np.isfinite(values)
        index, values = index[seen], values[seen]
        np.minimum.at(self._lower, index, values)
        np.maximum.at(self._upper, index, values)
        self._sum += np.bincount(index, values, len(self._sum))
        self._count += np.bincount(index, minlength=len(self._count))

    def trace(self) -> Trace:
        """What was collected; NaN where a bin saw no sample."""
        seen = self._count > 0
        mean = np.divide(self._sum, self._count, out=np.full(len(seen), np.nan), where=seen)
        time = (self._start or 0.0) + self._width * np.arange(len(seen))
        lower, upper = (np.where(seen, edge, np.nan) for edge in (self._lower, self._upper))
        return Trace(self.name, self.unit, time, lower, upper, mean)

    def _grow(self, size: int) -> None:
        more = max(size - len(self._count), 0)
        if more:
            self._lower = np.append(self._lower, np.full(more, np.inf))
            self._upper = np.append(self._upper, np.full(more, -np.inf))
            self._sum, self._count = (np.append(old, np.zeros(more)) for old in (self._sum, self._count))

    def _halve(self) -> None:
        self._grow(len(self._count) + len(self._count) % 2)
        self._lower = self._lower.reshape(-1, 2).min(axis=1)
        self._upper = self._upper.reshape(-1, 2).max(axis=1)
        self._sum, self._count = (old.reshape(-1, 2).sum(axis=1) for old in (self._sum, self._count))
        self._width *= 2.0
