"""Runs of true values in an array of flags."""

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
