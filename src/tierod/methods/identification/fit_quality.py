"""How well a model fits: simulated against measured, and whether what is left over is white."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.experiment import INTERVAL

LAGS = 25
"""Of the correlation of residuals with themselves."""


LEAST = 100
"""Third differences of neighbours that tell a noise, within a tenth."""


class Whiteness(NamedTuple):
    """Correlation of residuals with themselves.

    Args:
        largest: of lags 1 to 25, with its sign
        outside: share of these lags outside the 95 % of white noise; 0.05 is what chance gives
    """

    largest: float
    outside: float


def normalised_error(simulated: np.ndarray, measured: np.ndarray) -> float:
    """Root mean square of the difference over the standard deviation of what was measured; NaN where that is still."""
    known = np.isfinite(measured)
    spread = float(np.std(measured[known]))
    if not spread > 0.0:
        return float("nan")
    return float(np.sqrt(np.mean((simulated[known] - measured[known]) ** 2))) / spread


def white_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a signal, from its third differences, which motion hardly reaches.

    Args:
        values: sampled far above the frequencies of the motion; missing ones are left out, and passed over where no
            four neighbours are there
    """
    third = np.diff(values, 3)
    third = third[np.isfinite(third)]
    if len(third) < LEAST:
        third = np.diff(values[np.isfinite(values)], 3)
    return max(float(np.sqrt(np.mean(third**2) / 20.0)) if len(third) else 0.0, 1e-7)


def whiteness(residuals: Sequence[np.ndarray]) -> Whiteness:
    """Of the residuals of one output over several experiments, each (n,); missing ones are left out."""
    power = sum(float(np.nansum(each**2)) for each in residuals)
    count = sum(int(np.isfinite(each).sum()) for each in residuals)
    if not power > 0.0:
        return Whiteness(0.0, 0.0)
    found = [sum(float(np.nansum(e[lag:] * e[:-lag])) for e in residuals) / power for lag in range(1, LAGS + 1)]
    bound = INTERVAL / np.sqrt(count)
    return Whiteness(float(max(found, key=abs)), float(np.mean(np.abs(found) > bound)))
