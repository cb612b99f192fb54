"""Which signal of a turning car has the wrong sign, told from how the signals go together."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from tierod.monitors.harness.related_signals import odd_ones_out

TOGETHER = ("steering angle", "yaw rate", "lateral acceleration", "steering torque")
"""What has the same sign in a steady turn."""

CLEAR = 0.5
"""Correlation from which two signals are taken to go together or against each other. Slow turns give above 0.9."""

FASTEST_STANDING = 3.0
"""Speed [m/s] up to which the car is taken to manoeuvre, where torque and lateral acceleration tell little."""

FEWEST = 300
"""Samples from which on a correlation says something."""


class SignsOverDrive:
    """Products of the signals of `TOGETHER` over the pieces of a recording, where the car rolls."""

    def __init__(self) -> None:
        size = len(TOGETHER)
        self._products, self._squares = np.zeros((size, size)), np.zeros((size, size))
        self._counts = np.zeros((size, size))

    def add(self, speed: np.ndarray, signals: Mapping[str, np.ndarray]) -> None:
        """The next piece: speed [m/s] and the signals by their name in `TOGETHER`, (n,) each; NaN where missing."""
        rolling = np.isfinite(speed) & (speed > FASTEST_STANDING)
        for (i, one), (j, other) in combinations(enumerate(TOGETHER), 2):
            a, b = signals[one], signals[other]
            both = rolling & np.isfinite(a) & np.isfinite(b)
            x, y = a[both], b[both]
            self._products[i, j] += x @ y
            self._squares[i, j] += x @ x
            self._squares[j, i] += y @ y
            self._counts[i, j] += len(x)

    def agreements(self) -> dict[tuple[str, str], float]:
        """Correlation about zero of every pair that was seen long enough, -1 to 1."""
        found = {}
        for (i, one), (j, other) in combinations(enumerate(TOGETHER), 2):
            size = np.sqrt(self._squares[i, j] * self._squares[j, i])
            if self._counts[i, j] >= FEWEST and size > 0.0:
                found[one, other] = float(self._products[i, j] / size)
        return found

    def turned(self) -> tuple[str, ...]:
        """The signal of `TOGETHER` whose sign contradicts the others; several where they cannot be told apart."""
        clear = {pair: value > 0.0 for pair, value in self.agreements().items() if abs(value) > CLEAR}
        return odd_ones_out(TOGETHER, clear)
