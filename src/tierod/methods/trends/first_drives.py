"""The first drives of a car: what its level begins from must not rest on a wrong drive."""

from __future__ import annotations

import numpy as np

from tierod.methods.trends.drive_filter import TrendNoise
from tierod.methods.trends.drives import Drives

FIRST = 5
"""Drives from which the level of a car begins; no alarm is raised before it has as many."""

FAR = 4.0
"""Deviations from their median beyond which one of them is wrong: one right drive in 16 000."""


def with_right_first(drives: Drives, noise: TrendNoise, effects: np.ndarray) -> Drives:
    """The drives without those of each car's first ones that are far from the median of these.

    A first drive has no other to be held against: one that is wrong makes all later ones look changed.

    Args:
        drives: of all cars
        noise: of steady cars
        effects: of the regressors, (regressors,)
    """
    number = np.cumsum(drives.present, axis=1)
    first = drives.present & (number <= FIRST)
    value = np.where(first, drives.estimate - drives.effects @ effects, np.nan)
    middle = np.nanmedian(value, axis=1)
    # The median of a few drives is itself uncertain.
    spread = np.sqrt(noise.variance(drives.deviation) * (1.0 + 1.57 / FIRST))
    with np.errstate(invalid="ignore"):
        wrong = first & (np.abs(value - middle[:, None]) > FAR * spread) & (number[:, -1:] >= FIRST)
    return Drives(drives.day, np.where(wrong, np.nan, drives.estimate), drives.deviation, drives.regressors)
