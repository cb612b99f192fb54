"""Values that no vehicle reaches: removed before they decide, counted, and named."""

from __future__ import annotations

import numpy as np

from tierod.monitors.condition.signals import ConditionSample
from tierod.signals import SIGNALS

FAR = 10.0
"""So many times the plausible range of a signal no fault of a sensor gives; wrong units, as degrees, still may."""


class Impossible:
    """Removes what is infinite, or far beyond the plausible range of its signal, piece by piece."""

    def __init__(self) -> None:
        ranges = [SIGNALS[name].plausible for name in ConditionSample._fields]
        self._most = np.array([FAR * max(abs(low), abs(high)) for low, high in ranges])
        self._count = np.zeros(len(ranges), int)
        self._largest = np.zeros(len(ranges))

    def add(self, values: np.ndarray) -> np.ndarray:
        """The next piece without impossible values.

        Args:
            values: columns of `ConditionSample`, (n, signals); NaN where missing
        """
        size = np.abs(values)
        far = (size > self._most) | np.isinf(values)
        if not far.any():
            return values
        self._count += far.sum(axis=0)
        self._largest = np.maximum(self._largest, np.where(far, size, 0.0).max(axis=0))
        return np.where(far, np.nan, values)

    def notes(self) -> tuple[str, ...]:
        """What was removed, in words."""
        return tuple(
            f"{count} impossible value{'s' if count > 1 else ''} of {name.replace('_', ' ')}, up to {largest:.3g} "
            f"{SIGNALS[name].unit}".rstrip()
            + (" was" if count == 1 else " were")
            + " left out: check the sensor, its "
            "bus and its unit"
            for name, count, largest in zip(ConditionSample._fields, self._count.tolist(), self._largest, strict=True)
            if count
        )
