"""Time until a level with a linear trend reaches a limit, by quantiles."""

from __future__ import annotations

import numpy as np

HORIZON = 3652.5
"""Prediction horizon [d]: ten years. A later time counts as never."""

_STEPS = 60


def chance_by(level: np.ndarray, covariance: np.ndarray, limit: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Probability that the level is above the limit at a time ahead.

    Args:
        level: mean of level and slope now, (cars, 2)
        covariance: of level and slope, (cars, 2, 2)
        limit: upper limit in the unit of the level, (cars,)
        ahead: time from now [d], (cars,)
    """
    from scipy.special import ndtr

    mean = level[:, 0] + ahead * level[:, 1]
    variance = covariance[:, 0, 0] + 2.0 * ahead * covariance[:, 0, 1] + ahead**2 * covariance[:, 1, 1]
    return np.asarray(ndtr((mean - limit) / np.sqrt(np.maximum(variance, 1e-30))))


def time_to_limit(level: np.ndarray, covariance: np.ndarray, limit: np.ndarray, share: float) -> np.ndarray:
    """Time from now at which the probability of being above the limit reaches a share [d]; infinite beyond `HORIZON`.

    Args:
        limit: upper limit in the unit of the level, (cars,)
        share: probability [-]; 0.05 for the earliest time, 0.5 for the median

    The first passage is bracketed on a grid of times that grow by a twelfth, then bisected, since the probability need
    not be monotonic for a falling slope. The trend is extrapolated without process noise.
    """
    times = np.concatenate(([0.0], np.geomspace(1.0, HORIZON, 104)))
    low, high = np.zeros(len(level)), np.full(len(level), np.inf)
    for before, after in zip(np.concatenate(([0.0], times[:-1])), times, strict=True):
        reached = chance_by(level, covariance, limit, np.full(len(level), after)) >= share
        new = reached & np.isinf(high)
        low[new], high[new] = before, after
    known = np.isfinite(high)
    top = np.where(known, high, 1.0)
    for _ in range(_STEPS):
        middle = 0.5 * (low + top)
        reached = chance_by(level, covariance, limit, middle) >= share
        low, top = np.where(reached, low, middle), np.where(reached, middle, top)
    return np.where(known, top, np.inf)
