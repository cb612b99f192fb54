"""Values that no vehicle reaches: removed before they decide, counted, and named."""

from __future__ import annotations

import numpy as np

from tierod.core.signals import SIGNALS
from tierod.io.quality import impossible
from tierod.monitors.condition.signals import ConditionSample


class ImpossibleValues:
    """Removes what is infinite, or far beyond the plausible range of its signal, piece by piece."""

    def __init__(self) -> None:
        self._count = np.zeros(len(ConditionSample._fields), int)
        self._largest = np.zeros(len(ConditionSample._fields))

    def add(self, values: np.ndarray) -> np.ndarray:
        """The next piece without impossible values.

        Args:
            values: columns of `ConditionSample`, (n, signals); NaN where missing
        """
        pairs = zip(ConditionSample._fields, values.T, strict=True)
        far = np.column_stack([impossible(name, column) for name, column in pairs])
        if not far.any():
            return values
        self._count += far.sum(axis=0)
        self._largest = np.maximum(self._largest, np.where(far, np.abs(values), 0.0).max(axis=0))
        return np.where(far, np.nan, values)

    def notes(self) -> tuple[str, ...]:
        """What was removed, in words."""
        return tuple(
            f"{count} impossible value{'s' if count > 1 else ''} of {name.replace('_', ' ')}, up to "
            + f"{largest:.3g} {SIGNALS[name].unit}".rstrip()
            + f" {'was' if count == 1 else 'were'} left out: check the sensor, its bus and its unit"
            for name, count, largest in zip(ConditionSample._fields, self._count.tolist(), self._largest, strict=True)
            if count
        )
