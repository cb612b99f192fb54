"""Standard deviations from medians, which a few outliers hardly change."""

from __future__ import annotations

import numpy as np

DEVIATION_OF_MEDIAN = 1.4826
"""Standard deviation of a normal quantity over the median of its magnitude [-]."""

VARIANCE_ERROR = 2.33
"""Relative standard error of a variance by `usual_deviation`, times the square root of the number of errors [-]. For
normal errors the median absolute deviation has 1.17, and its square twice that."""


def usual_deviation(errors: np.ndarray) -> float:
    """Standard deviation of normal errors that have the same median absolute value as the given ones."""
    return float(np.median(np.abs(errors))) * DEVIATION_OF_MEDIAN
