"""A sum that is the same to the last bit however its parts come."""

from __future__ import annotations

import numpy as np

BLOCK = 1000
"""Values that are summed together."""


class BlockSum:
    """Adds values up, in blocks of a fixed number of them."""

    def __init__(self) -> None:
        self._total, self._rest = 0.0, np.zeros(0)

    def add(self, values: np.ndarray) -> None:
        """The next values, (n,)."""
        values = np.concatenate([self._rest, values])
        whole = len(values) // BLOCK * BLOCK
        for part in values[:whole].reshape(-1, BLOCK).sum(axis=1):
            self._total += float(part)
        self._rest = values[whole:]

    @property
    def value(self) -> float:
        """The sum so far."""
        return self._total + float(self._rest.sum())
