"""Helpers for sampled series: runs of true values, decimation across pieces, and a growing table of rows."""

from __future__ import annotations

import numpy as np


def runs(flags: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First index, and one past the last index, of every run of true values, in order.

    Args:
        flags: (n,)
    """
    edges = np.flatnonzero(np.diff(np.asarray(flags, dtype=bool), prepend=False, append=False))
    return edges[::2], edges[1::2]


def longest_run(flags: np.ndarray) -> int:
    """The length of the longest run of true values; 0 where there is none.

    Args:
        flags: (n,)
    """
    begins, ends = runs(flags)
    return int((ends - begins).max(initial=0))


def last_true(flags: np.ndarray) -> int | None:
    """Index of the last true value; None where there is none.

    Args:
        flags: (n,)
    """
    at = len(flags) - 1 - int(np.argmax(flags[::-1])) if len(flags) else 0
    return at if len(flags) and flags[at] else None


class LastRead:
    """Last reading of each signal across consecutive pieces, since slow buses do not bring it with every sample.

    Args:
        fresh: longest time for which a reading holds [s]
    """

    def __init__(self, columns: int, fresh: float):
        self._fresh = fresh
        self._values, self._times = np.full((1, columns), np.nan), np.full((1, columns), -np.inf)

    def held(self, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Last reading at each sample of the next piece, (n, columns); NaN where it is older than `fresh`.

        Args:
            time: time stamps [s], (n,)
            values: readings, (n, columns); NaN where there is none
        """
        values = np.vstack((self._values, values))
        times = np.vstack((self._times, np.repeat(time[:, None], values.shape[1], axis=1)))
        place = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values))[:, None], 0), axis=0)
        held, read = (np.take_along_axis(each, place, axis=0) for each in (values, times))
        self._values, self._times = held[-1:], read[-1:]
        return np.where(times[1:] - read[1:] <= self._fresh, held[1:], np.nan)


class Stride:
    """Decimation across consecutive pieces: the first sample of all, then every `step`-th one."""

    def __init__(self, step: int):
        self.step = step
        self._seen = 0

    def over(self, count: int) -> slice:
        """Slice of the samples to take from the next piece."""
        first = -self._seen % self.step
        self._seen += count
        return slice(first, None, self.step)

    def indices(self, count: int) -> np.ndarray:
        """Indices of the samples to take from the next piece, in place of `over`."""
        return np.arange(count)[self.over(count)]


class Rows:
    """Growing table of rows of numbers, in one array that doubles when it is full.

    A list of slices would keep the whole arrays that they were cut from, and cost an object per slice.

    Args:
        most: largest number of rows; further ones are dropped; None keeps all
    """

    def __init__(self, columns: int, most: int | None = None):
        self._most, self._count = most, 0
        self._values = np.empty((0, columns))

    def __len__(self) -> int:
        return self._count

    @property
    def full(self) -> bool:
        """Whether further rows are dropped."""
        return self._most is not None and self._count >= self._most

    @property
    def values(self) -> np.ndarray:
        """All rows, (n, columns); valid until more are added."""
        return self._values[: self._count]

    def add(self, rows: np.ndarray) -> None:
        """Append rows, (n, columns)."""
        rows = rows if self._most is None else rows[: max(self._most - self._count, 0)]
        needed = self._count + len(rows)
        if needed > len(self._values):
            larger = np.empty((max(needed, 2 * len(self._values)), self._values.shape[1]))
            larger[: self._count] = self.values
            self._values = larger
        self._values[self._count : needed] = rows
        self._count = needed
