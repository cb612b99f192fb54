"""Parts of a series of samples: runs of true values, and every k-th sample wherever its pieces are cut."""

from __future__ import annotations

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


class Stride:
    """Takes the first sample of all, then every `step`-th one.

    Args:
        step: samples from one that is taken to the next
    """

    def __init__(self, step: int):
        self.step = step
        self._seen = 0

    def over(self, count: int) -> slice:
        """Which of the samples of the next piece are taken.

        Args:
            count: samples of the piece
        """
        first = -self._seen % self.step
        self._seen += count
        return slice(first, None, self.step)
