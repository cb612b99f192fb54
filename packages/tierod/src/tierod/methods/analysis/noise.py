"""White noise of readings, from their differences, which hardly contain the motion, and robust standard deviations."""

from __future__ import annotations

import math

import numpy as np

LEAST = 100
"""Smallest number of third differences for the standard deviation of a noise, which they give within a tenth."""


def differences(values: np.ndarray, order: int = 3, taken: int = 0) -> np.ndarray:
    """Differences of readings, each with the variance of their white noise; third ones vanish for a parabola.

    Args:
        values: readings, (..., n)
        taken: order of the differences that the values are already, such as the turns of an angle that wraps
    """
    # The squares of the binomial coefficients sum to 6 for the second differences, and to 20 for the third.
    return np.asarray(np.diff(values, order - taken) / math.sqrt(math.comb(2 * order, order)))


def fresh(values: np.ndarray) -> np.ndarray:
    """Indices of the samples that hold a new reading; held samples count once.

    Args:
        values: samples (n,) without NaN
    """
    return np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)


def white_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a signal.

    Args:
        values: sampled far above the frequencies of the motion; differences with missing values are left out, or the
            gaps closed where that leaves too few
    """
    third = differences(values)
    third = third[np.isfinite(third)]
    if len(third) < LEAST:
        third = differences(values[np.isfinite(values)])
    return max(math.sqrt(float(np.mean(third**2))) if len(third) else 0.0, 1e-7)


DEVIATION_OF_MEDIAN = 1.4826  # Standard deviation of a normal quantity over the median of its magnitude [-]

VARIANCE_ERROR = 2.33
"""Relative standard error of a variance by `usual_deviation`, times the square root of the number of errors [-]. For
normal errors the median absolute deviation has 1.17, and its square twice that."""


def usual_deviation(errors: np.ndarray) -> float:
    """Standard deviation of normal errors that have the same median absolute value as the given ones."""
    return float(np.median(np.abs(errors))) * DEVIATION_OF_MEDIAN
