"""Signals averaged over blocks of time, in pieces, so that the result does not depend on how a recording is cut."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

BLOCK = 0.5
"""Time over which signals are averaged [s]; noise of wheel speeds is .02 m/s**2 in its slope."""
LEAST_READ = 0.15
"""Share of the samples of a block that a signal must have; wheel speeds come at 20 Hz on slow buses."""

_TIME = "time"


class Blocks:
    """Cuts a drive into blocks, and keeps what is left of each piece for the next one.

    Args:
        rate: of the samples [Hz]
    """

    def __init__(self, rate: float):
        self.rate, self.width = rate, max(round(BLOCK * rate), 2)
        self._left: dict[str, np.ndarray] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[float]]:
        """The blocks that the next piece completes, and the end of each.

        Args:
            time: [s], (n,); it leaps where a pause of the recording was skipped
            signals: by name, (n,) each; NaN where missing

        Returns:
            signals by name, (blocks, samples) each, and the ends [s], (blocks,)
        """
        pieces = {**signals, _TIME: time}
        whole = {name: np.concatenate([self._left.get(name, values[:0]), values]) for name, values in pieces.items()}
        count = len(whole[_TIME]) // self.width
        used = count * self.width
        self._left = {name: values[used:].copy() for name, values in whole.items()}
        cut = {name: values[:used].reshape(count, self.width) for name, values in whole.items()}
        ends: list[float] = (cut.pop(_TIME)[:, -1] + 1.0 / self.rate).tolist()
        return cut, ends

    def line(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and slope per second of every block, (blocks,) each; NaN where too few samples are read."""
        there = np.isfinite(values)
        weight = there.astype(float)
        count = weight.sum(axis=1)
        time = (np.arange(self.width) - 0.5 * (self.width - 1)) / self.rate
        known, safe = np.where(there, values, 0.0), np.maximum(count, 1.0)
        mean, middle = known.sum(axis=1) / safe, (weight * time).sum(axis=1) / safe
        apart = (time - middle[:, None]) * weight
        spread = (apart * time).sum(axis=1)
        slope = (apart * known).sum(axis=1) / np.where(spread > 0.0, spread, 1.0)
        enough = (count >= max(LEAST_READ * self.width, 3.0)) & (spread > 0.0)
        return np.where(enough, mean - slope * middle, np.nan), np.where(enough, slope, np.nan)


def roughness(values: np.ndarray) -> np.ndarray:
    """Standard deviation of the noise of every block, from the steps between samples; NaN where few follow each other.

    Args:
        values: (blocks, samples)
    """
    steps = np.diff(values, axis=1)
    there = np.isfinite(steps)
    count = there.sum(axis=1)
    squares = np.where(there, steps * steps, 0.0).sum(axis=1)
    return np.where(count >= 3, np.sqrt(0.5 * squares / np.maximum(count, 1)), np.nan)
