"""Parts of a series of samples: runs of true values, and every k-th sample wherever its pieces are cut."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np


def runs(flags: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First index, and one past the last, of every run of true values, in order.

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


class Stride:
    """Takes the first sample of all, then every `step`-th one.

    Args:
        step: samples from one that is taken to the next
    """

    def __init__(self, step: int):
        self.step = step
        self._seen = 0

    def over(self, count: int) -> slice:
        """Slice of the samples to take from the next piece.

        Args:
            count: samples of the piece
        """
        first = -self._seen % self.step
        self._seen += count
        return slice(first, None, self.step)


class Rows:
    """Rows of numbers that follow each other, in one array that doubles when it is full.

    A list of pieces would keep the whole arrays that they were cut from, and cost an object for every piece.

    Args:
        columns: numbers of a row
        most: rows that are kept; further ones are left out; None keeps all

    `reserving` lets all that are made from then on take the memory of `most` rows at once.
    """

    reserving = False
    """For programs that run for hours, whose size is then known after minutes."""

    def __init__(self, columns: int, most: int | None = None):
        self._most, self._count = most, 0
        # Zeros by `full`, not by `zeros`: the system gives a page only when something is written to it.
        self._values = np.full((most if Rows.reserving and most is not None else 0, columns), 0.0)

    @classmethod
    @contextmanager
    def growing(cls) -> Iterator[None]:
        """Within, none takes its memory at once: for what lasts a minute only."""
        before, Rows.reserving = Rows.reserving, False
        try:
            yield
        finally:
            Rows.reserving = before

    def __len__(self) -> int:
        return self._count

    @property
    def full(self) -> bool:
        """Whether further rows are left out."""
        return self._most is not None and self._count >= self._most

    @property
    def values(self) -> np.ndarray:
        """All rows, (n, columns); valid until more are added."""
        return self._values[: self._count]

    def add(self, rows: np.ndarray) -> None:
        """Rows that follow, (n, columns)."""
        rows = rows if self._most is None else rows[: max(self._most - self._count, 0)]
        needed = self._count + len(rows)
        if needed > len(self._values):
            larger = np.empty((max(needed, 2 * len(self._values)), self._values.shape[1]))
            larger[: self._count] = self.values
            self._values = larger
        self._values[self._count : needed] = rows
        self._count = needed
