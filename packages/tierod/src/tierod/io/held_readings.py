"""Readings that are held: a file repeats each in many rows, as the rows are faster than the source of the signal."""

from __future__ import annotations

import numpy as np

# Numbers of changes of a signal from which it is judged, and after which further ones are not kept
FEWEST, MOST = 30, 2000

LEAST_ROWS = 4  # Least rows per reading: below it an interpolated or resampled signal looks the same

# Least share of the changes that come whole periods apart, to one row: a signal that rests changes at any time
REGULAR = 0.95

# Least share of changes larger than one and a half steps: a signal with coarse steps that moves slowly and evenly
# changes regularly too, but by one step each
LARGE = 0.5


class HeldReadings:
    """Finds how many rows repeat each reading of one signal, over the pieces of a recording."""

    def __init__(self) -> None:
        self._rows: list[int] = []
        self._sizes: list[float] = []
        self._last = np.nan
        self._since: int | None = None

    def add(self, values: np.ndarray) -> None:
        """Add the next rows, (n,); NaN where missing."""
        if len(self._rows) >= MOST:
            return
        values = values[np.isfinite(values)]
        steps = np.abs(np.diff(values, prepend=self._last))
        at = np.flatnonzero(steps > 0.0)
        if len(values):
            self._last = float(values[-1])
        # The time before the first change is no whole period.
        starts = at if self._since is None else np.concatenate([[-self._since], at])
        self._rows += np.diff(starts).tolist()
        self._sizes += steps[at if self._since is not None else at[1:]].tolist()
        if len(starts):
            self._since = len(values) - int(starts[-1])

    def rows(self) -> float:
        """Rows that repeat one reading; 1 where readings are not held."""
        if len(self._rows) < FEWEST:
            return 1.0
        apart, sizes = np.array(self._rows, float), np.array(self._sizes)
        period = float(np.quantile(apart, 0.1))
        if period < LEAST_ROWS:
            return 1.0
        period = float(np.mean(apart[apart < 1.5 * period]))
        times = np.maximum(np.round(apart / period), 1.0)
        regular = np.abs(apart - times * period) <= np.maximum(1.0, 0.02 * apart)
        if np.mean(regular) < REGULAR or np.mean(sizes > 1.5 * sizes.min()) < LARGE:
            return 1.0
        return period


def rows_per_reading(values: np.ndarray) -> float:
    """Rows that repeat one reading of a whole signal, (n,); 1 where readings are not held."""
    held = HeldReadings()
    held.add(values)
    return held.rows()


def held_remark(rate: float, rows: float) -> str:
    """Remark on held readings.

    Args:
        rate: rate of the rows [Hz]
    """
    return f"readings come at {rate / rows:.3g} Hz only: each is repeated in {rows:.0f} rows"
