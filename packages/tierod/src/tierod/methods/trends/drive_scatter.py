"""Scatter between drives of the same car, estimated from a fleet beside the deviation that each drive states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.robust import VARIANCE_ERROR, usual_deviation

LEAST = 30
"""Smallest number of pairs of drives for an estimate: they give a standard deviation to 13 %."""

MOST = 400_000
"""Largest number of pairs that are used, evenly spaced among all: they give a standard deviation to 0.11 %."""

NEAR = 30.0
"""Longest time between two drives of a pair [d], over which wear is negligible."""

WRONG = 5.0
"""Standard deviation of wrong drives (outliers) over that of the others [-]."""


@dataclass(frozen=True)
class DriveScatter:
    """Estimated scatter of drives of the same car.

    Args:
        scatter: standard deviation from drive to drive beside the stated ones [unit]
        scale: true error over the stated one [-]; where the stated deviations are too alike to separate both, 1 or less
        effects: change of the estimate per unit of each regressor, (regressors,)
        differing: upper estimate of the standard deviation of each effect from car to car, (regressors,)
    """

    scatter: float
    scale: float
    wrong_share: float
    effects: np.ndarray
    differing: np.ndarray
    pairs: int
    separated: bool


def drive_scatter(drives: Drives) -> DriveScatter:
    """Maximum-likelihood estimate of scatter and scale from the differences between neighbouring drives of each car.

    Differences do not depend on the level of the car, and hardly on its wear. Their likelihood is that of two Gaussian
    errors, each of which may be an outlier, so that a few wrong drives do not widen it. It is a composite likelihood,
    since neighbouring differences share a drive; the estimates stay consistent. Source: C. Varin et al., 2011,
    Statistica Sinica 21, 5-42; outliers after J. W. Tukey, 1960.

    Raises:
        InputError: fewer than `LEAST` pairs
    """
    from scipy.optimize import minimize

    change, first, second, moved = _pairs(drives)
    if len(change) < LEAST:
        raise InputError(
            f"{len(change)} pairs of drives of the same car within {NEAR:g} days; the scatter between drives is learnt "
            f"from {LEAST} or more: give more drives, or state the scatter"
        )
    effects = _robust_slopes(change, moved)
    rest = change - moved @ effects
    stated = first**2 + second**2
    level = usual_deviation(rest)
    low, high = np.quantile(stated, (0.1, 0.9))
    # Only stated deviations that differ between drives separate the scale from a constant scatter.
    separated = bool(high > 2.0 * low)
    begin = [np.log(max(level, 1e-9) / np.sqrt(2.0)), np.log(0.5) if separated else -np.inf, np.log(0.03 / 0.97)]

    def unlikely(values: np.ndarray) -> float:
        scatter, share = np.exp(values[0]), 1.0 / (1.0 + np.exp(-values[1]))
        scale = np.exp(values[2]) if separated else 0.0
        variance = scale**2 * stated + 2.0 * scatter**2
        return -float(np.sum(_mixture(rest**2, variance, share)))

    start = np.array([begin[0], begin[2], begin[1]] if separated else [begin[0], begin[2]])
    best = minimize(unlikely, start, method="Nelder-Mead", options={"maxiter": 2000, "fatol": 1e-3, "xatol": 1e-4}).x
    scatter, share = float(np.exp(best[0])), float(1.0 / (1.0 + np.exp(-best[1])))
    scale = float(np.exp(best[2])) if separated else _rest_scale(scatter, stated)
    scatter = scatter if separated else _rest_scatter(scatter, stated)
    return DriveScatter(scatter, scale, share, effects, _differing(rest, moved), len(change), separated)


def _rest_scale(whole: float, stated: np.ndarray) -> float:
    """Scale where it cannot be separated from the scatter: 1, or less where the drives scatter less than they state."""
    return float(min(1.0, whole / np.sqrt(0.5 * np.median(stated))))


def _rest_scatter(whole: float, stated: np.ndarray) -> float:
    return float(np.sqrt(max(whole**2 - 0.5 * float(np.median(stated)), 0.0)))


def _mixture(square: np.ndarray, variance: np.ndarray, share: float) -> np.ndarray:
    chances = ((1.0 - share) ** 2, 2.0 * share * (1.0 - share), share**2)
    wider = (1.0, 0.5 * (1.0 + WRONG**2), WRONG**2)
    parts = [
        np.log(chance / np.sqrt(wide)) - 0.5 * square / (wide * variance)
        for chance, wide in zip(chances, wider, strict=True)
    ]
    return np.asarray(np.logaddexp.reduce(parts) - 0.5 * np.log(variance))


def _pairs(drives: Drives) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    both = drives.present[:, 1:] & drives.present[:, :-1]
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(both & (np.diff(drives.day, axis=1) <= NEAR))
    near = near[:: max(-(-len(near) // MOST), 1)]
    car, first = np.unravel_index(near, both.shape)
    effects = drives.effects
    return (
        drives.estimate[car, first + 1] - drives.estimate[car, first],
        drives.deviation[car, first],
        drives.deviation[car, first + 1],
        effects[car, first + 1] - effects[car, first],
    )


def _differing(rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Standard deviations of effects from car to car, from the wider scatter of pairs with large regressor differences.

    Each variance is its estimate, at least zero, plus its standard error: an upper value that the drives allow.
    """
    found = np.full(moved.shape[1], np.inf)
    for number, along in enumerate(moved.T**2):
        far = along > np.median(along)
        more = along[far].mean() - along[~far].mean() if far.any() else 0.0
        if more <= 0.0:
            continue
        wide, near = (usual_deviation(rest[of]) ** 2 for of in (far, ~far))
        error = VARIANCE_ERROR * np.hypot(wide, near) / np.sqrt(0.5 * len(rest))
        found[number] = np.sqrt((max(wide - near, 0.0) + error) / more)
    return found


def _robust_slopes(change: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Least squares with Huber's weights; a ridge keeps the coefficients of nearly constant regressors near zero."""
    weight = np.ones(len(change))
    count = moved.shape[1]
    if not count:
        return np.zeros(0)
    ridge = 1e-6 * np.eye(count)
    slopes = np.zeros(count)
    for _ in range(20):
        normal = moved.T @ (weight[:, None] * moved)
        slopes = np.linalg.solve(normal + ridge * max(np.trace(normal), 1e-12), moved.T @ (weight * change))
        rest = change - moved @ slopes
        size = max(usual_deviation(rest), 1e-12)
        weight = 1.0 / np.maximum(1.0, np.abs(rest) / (1.5 * size))
    return slopes
