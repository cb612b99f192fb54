"""Rejection of outliers among the first drives of a car, from which its level starts."""

from __future__ import annotations

import numpy as np

from tierod.methods.trends.drive_filter import TrendNoise
from tierod.methods.trends.drives import Drives

FIRST = 5
"""Number of first drives that are compared with each other; no alarm is raised before a car has as many."""

FAR = 4.0
"""Distance from the median [standard deviations] beyond which a first drive is wrong: one of 16 000 right ones is."""


def with_right_first(drives: Drives, noise: TrendNoise, effects: np.ndarray) -> Drives:
    """The drives without those of each car's first `FIRST` that are far from the median of these.

    The filter has no earlier drive to compare a first drive with: a wrong one makes all later ones appear changed.

    Args:
        effects: of the regressors on the estimate, (regressors,)
    """
    number = np.cumsum(drives.present, axis=1)
    first = drives.present & (number <= FIRST)
    value = np.where(first, drives.estimate - drives.effects @ effects, np.nan)
    middle = np.nanmedian(value, axis=1)
    # The variance of the median of n normal values is pi / 2 of that of their mean.
    spread = np.sqrt(noise.variance(drives.deviation) * (1.0 + 1.57 / FIRST))
    with np.errstate(invalid="ignore"):
        wrong = first & (np.abs(value - middle[:, None]) > FAR * spread) & (number[:, -1:] >= FIRST)
    return Drives(drives.day, np.where(wrong, np.nan, drives.estimate), drives.deviation, drives.regressors)
