"""Thresholds of `Cusum` for a tolerated rate of false alarms, on white Gaussian residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tierod.core.errors import ParameterError

WAYS = {"both": (1.0, -1.0), "upper": (1.0,), "lower": (-1.0,)}
"""Signs of the changes that a detector looks for, by its sides."""

OVERSHOOT = 1.166  # Siegmund's correction for the jump across both boundaries, 2 * 0.583


def run_length(drift: float, threshold: float, change: float = 0.0, sides: str = "both") -> float:
    """Average run length of `Cusum`: samples between false alarms without a change, detection delay with one.

    Args:
        drift, threshold: of the detector, in standard deviations of the residual
        change: mean of the residual, in standard deviations
        sides: "both", "upper" or "lower"

    Within about 10 % of the true value for a threshold of at least 3. Autocorrelated residuals alarm far more often:
    use every n-th one, or whiten them.

    Source: D. Siegmund, Sequential Analysis, 1985, (2.57): (exp(-2 D b) + 2 D b - 1) / (2 D^2), D = change - drift,
    b = threshold + 1.166.
    """
    _check(drift, threshold, sides)
    return together([_one_sided(way * change - drift, threshold) for way in WAYS[sides]])


def together(lengths: Sequence[float]) -> float:
    """Expected samples until the first of several independent detectors alarms, from those of each."""
    rate = sum(1.0 / length for length in lengths)
    return 1.0 / rate if rate > 0.0 else math.inf


def threshold_for(drift: float, samples: float, sides: str = "both") -> float:
    """Threshold for a mean number of samples between false alarms, in standard deviations of the residual.

    Args:
        drift: of the detector, in standard deviations
        samples: wanted mean number of samples between false alarms; for one per T seconds at rate f, T f
        sides: "both", "upper" or "lower"

    Raises:
        ParameterError: so few samples that no threshold is needed
    """
    from scipy.optimize import brentq

    _check(drift, 1.0, sides)
    if not math.isfinite(samples) or samples <= run_length(drift, 1e-9, sides=sides):
        raise ParameterError(
            f"{samples} samples between false alarms are fewer than a detector without threshold gives; ask for more"
        )
    high = 1.0
    while run_length(drift, high, sides=sides) < samples:
        high *= 2.0
    return float(brentq(lambda h: math.log(run_length(drift, h, sides=sides) / samples), 1e-9, high, xtol=1e-10))


def _one_sided(mean: float, threshold: float) -> float:
    height = threshold + OVERSHOOT
    exponent = -2.0 * mean * height
    # Below 1e-5 the closed form is 0 / 0 within rounding; its limit is the square of the height.
    if abs(exponent) < 1e-5:
        return height * height
    if exponent > 700.0:
        return math.inf
    return (math.expm1(exponent) - exponent) / (2.0 * mean * mean)


def _check(drift: float, threshold: float, sides: str) -> None:
    if sides not in WAYS:
        raise ParameterError(f"sides is '{sides}'; expected {', '.join(WAYS)}")
    if not (drift >= 0.0 and threshold > 0.0):
        raise ParameterError(f"drift is {drift} and threshold {threshold}; expected drift >= 0 and threshold > 0")
