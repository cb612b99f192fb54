"""Deviations by medians, which a few errors of another size do not widen."""

from __future__ import annotations

import numpy as np

VARIANCE_ERROR = 2.33
"""Standard error of a variance by `usual_deviation`, over that variance and times the root of the number of errors: a
normal distribution's median absolute deviation has 1.17, and its square twice that."""


def usual_deviation(errors: np.ndarray) -> float:
    """Standard deviation of normal errors whose median absolute value is that of the given ones.

    Args:
        errors: about their middle, one or more
    """
    return float(np.median(np.abs(errors))) / 0.6745
