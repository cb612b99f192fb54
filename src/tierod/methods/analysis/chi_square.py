"""Chi-square bands, and the squared errors that they judge."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tierod.core.errors import InputError

CONFIDENCE = 0.95  # of every band; the share that textbooks and reviewers expect


def chi_square_quantile(probability: float, degrees: Any) -> Any:
    """Quantile of the chi-square distribution; of one degree, that of a squared normal variable."""
    if np.ndim(degrees) == 0 and degrees == 1:
        from statistics import NormalDist

        return NormalDist().inv_cdf(0.5 * (1.0 + probability)) ** 2

    from scipy.special import gammaincinv

    return 2.0 * gammaincinv(np.asarray(degrees, float) / 2.0, probability)


def mean_band(degrees: int, count: int | None = None) -> tuple[float, float]:
    """95 % band of a chi-square sum with this many degrees, per degree (or per `count`)."""
    if not degrees:
        return (math.nan, math.nan)
    low, high = (1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0
    per = degrees if count is None else count
    return (float(chi_square_quantile(low, degrees)) / per, float(chi_square_quantile(high, degrees)) / per)


def normalised_error_squared(error: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """e' P^-1 e of every sample, (n,); NaN where an error or a covariance is not finite or not positive.

    Args:
        error: estimate minus truth, (n, states)
        covariance: packed covariance (n, states (states + 1) / 2), or variances (n, states)
    """
    error, covariance = np.asarray(error, float), np.asarray(covariance, float)
    if error.ndim != 2 or covariance.ndim != 2 or len(error) != len(covariance):
        raise InputError(f"error has the shape {error.shape} and covariance {covariance.shape}; expected (n, ...) both")
    n = error.shape[1]
    if covariance.shape[1] == n:
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where((covariance > 0.0).all(axis=1), (error**2 / covariance).sum(axis=1), np.nan)
    if covariance.shape[1] != n * (n + 1) // 2:
        raise InputError(
            f"covariance has {covariance.shape[1]} columns for {n} states; expected {n} variances or "
            f"{n * (n + 1) // 2} packed entries"
        )
    full = np.empty((len(error), n, n))
    rows, columns = np.triu_indices(n)
    full[:, rows, columns] = full[:, columns, rows] = covariance
    result = np.full(len(error), np.nan)
    good = np.isfinite(full).all(axis=(1, 2)) & np.isfinite(error).all(axis=1)
    good[good] &= np.linalg.eigvalsh(full[good])[:, 0] > 0.0
    solved = np.linalg.solve(full[good], error[good][:, :, None])[:, :, 0]
    result[good] = (error[good] * solved).sum(axis=1)
    return result
