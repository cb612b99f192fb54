"""Sum of a sequence that is bit-identical however the sequence is cut into parts."""

from __future__ import annotations

import numpy as np

BLOCK = 1000
"""Number of values per block."""


class BlockSum:
    """Adds values block by block: floating-point addition is not associative, so the cuts must not move the blocks."""

    def __init__(self) -> None:
        self._total, self._rest = 0.0, np.zeros(0)

    def add(self, values: np.ndarray) -> None:
        """Add the next values, (n,)."""
        values = np.concatenate([self._rest, values])
        whole = len(values) // BLOCK * BLOCK
        for part in values[:whole].reshape(-1, BLOCK).sum(axis=1):
            self._total += float(part)
        self._rest = values[whole:]

    @property
    def value(self) -> float:
        """Sum of all values so far."""
        return self._total + float(self._rest.sum())
