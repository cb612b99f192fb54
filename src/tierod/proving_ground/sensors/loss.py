"""Frames that get lost on a bus."""

from __future__ import annotations

import numpy as np


def lost_frames(count: int, share: float, mean_run: float, generator: np.random.Generator) -> np.ndarray:
    """Which of many frames get lost, shape (count,).

    Args:
        count: how many frames
        share: of frames that get lost in the long run, below 1
        mean_run: mean number of frames lost in a row, at least `share / (1 - share)`
        generator: source of chance

    Source: E. N. Gilbert, Capacity of a burst-noise channel, Bell System Technical Journal 39 (1960): a chain of two
    states, here with no loss in the good one and no frame in the bad one.
    """
    mean_good = mean_run * (1.0 - share) / share
    bad = generator.random() < share
    pieces: list[np.ndarray] = []
    total = 0
    while total < count:
        expected = max(16, int(1.2 * (count - total) / (mean_good + mean_run)))
        runs = np.empty(2 * expected, dtype=int)
        runs[int(not bad) :: 2] = generator.geometric(1.0 / mean_run, expected)
        runs[int(bad) :: 2] = generator.geometric(1.0 / mean_good, expected)
        states = np.arange(2 * expected) % 2 == int(not bad)
        pieces.append(np.repeat(states, runs))
        total += len(pieces[-1])
    return np.concatenate([*pieces, np.zeros(0, dtype=bool)])[:count]
