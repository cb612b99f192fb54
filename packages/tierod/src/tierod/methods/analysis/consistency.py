"""Noise on a signal, and consistency of a filter: NIS and its bands."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np

# Smallest number of third differences for the standard deviation of a noise, which they give within a tenth
LEAST = 100


def differences(values: np.ndarray, order: int = 3, taken: int = 0) -> np.ndarray:
    """Differences of readings, each with the variance of their white noise; third ones vanish for a parabola."""
    # The squares of the binomial coefficients sum to 6 for the second differences, and to 20 for the third.
    return np.asarray(np.diff(values, order - taken) / math.sqrt(math.comb(2 * order, order)))


def fresh(values: np.ndarray) -> np.ndarray:
    """Indices of the samples that hold a new reading; held samples count once.

    Args: values: samples (n,) without NaN.
    """
    return np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)


def white_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a signal.

    Args: values: sampled far above the frequencies of the motion; differences with missing values are left out, or the
    gaps closed where that leaves too few.
    """
    third = differences(values)
    third = third[np.isfinite(third)]
    if len(third) < LEAST:
        third = differences(values[np.isfinite(values)])
    return max(math.sqrt(float(np.mean(third**2))) if len(third) else 0.0, 1e-7)


DEVIATION_OF_MEDIAN = 1.4826  # Standard deviation of a normal quantity over the median of its magnitude [-]
# Relative standard error of a variance by `usual_deviation`, times the square root of the number of errors [-]. For
# normal errors the median absolute deviation has 1.17, and its square twice that.
VARIANCE_ERROR = 2.33


def usual_deviation(errors: np.ndarray) -> float:
    """Standard deviation of normal errors that have the same median absolute value as the given ones."""
    return float(np.median(np.abs(errors))) * DEVIATION_OF_MEDIAN


STEPS = 60  # Largest number of steps of Newton's method and bisection; six are usual
TERMS = 10_000  # Largest number of terms of a series, which grows with the square root of the shape
# Shape up to which the series are summed; above, the error of Wilson and Hilferty's cube root is below rounding
MOST_SHAPE = 1e6


def lower_gamma(shape: float, x: float) -> float:
    """Regularised lower incomplete gamma function P(shape, x): distribution function of a gamma variable.

    Source: Press et al., Numerical Recipes, 3rd ed., section 6.2: the series below shape + 1, the continued fraction of
    Lentz above.
    """
    if x <= 0.0:
        return 0.0
    scale = math.exp(shape * math.log(x) - x - math.lgamma(shape))
    return scale * _series(shape, x) if x < shape + 1.0 else 1.0 - scale * _fraction(shape, x)


def _series(shape: float, x: float) -> float:
    total = term = 1.0 / shape
    for step in range(1, TERMS):
        term *= x / (shape + step)
        total += term
        if term < total * sys.float_info.epsilon:
            break
    return total


def _fraction(shape: float, x: float) -> float:
    tiny = sys.float_info.min
    b = x + 1.0 - shape
    c, d = 1.0 / tiny, 1.0 / b
    total = d
    for step in range(1, TERMS):
        a = -step * (step - shape)
        b += 2.0
        d = 1.0 / (a * d + b or tiny)
        c = b + a / c or tiny
        total *= d * c
        if abs(d * c - 1.0) < sys.float_info.epsilon:
            break
    return total


def gamma_quantile(shape: float, probability: float) -> float:
    """Quantile of the gamma distribution: the x with P(shape, x) = probability.

    Source: Newton's method inside a bracket, started at the cube root of Wilson and Hilferty (1931).
    """
    if not (shape > 0.0 and 0.0 < probability < 1.0):
        raise ValueError(f"shape is {shape} and probability {probability}; expected > 0, and between 0 and 1")
    ninth = 1.0 / (9.0 * shape)
    x = shape * max(1.0 - ninth + NormalDist().inv_cdf(probability) * math.sqrt(ninth), 1e-3) ** 3
    if shape > MOST_SHAPE:
        return x
    low, high = 0.0, math.inf
    for _ in range(STEPS):
        error = lower_gamma(shape, x) - probability
        low, high = (low, x) if error > 0.0 else (x, high)
        density = math.exp((shape - 1.0) * math.log(x) - x - math.lgamma(shape))
        following = x - error / density if density > 0.0 else math.inf
        if not low < following < high:
            following = 0.5 * (low + high) if math.isfinite(high) else 2.0 * x
        if abs(following - x) <= 4.0 * sys.float_info.epsilon * x:
            return following
        x = following
    return x


CONFIDENCE = 0.95  # of every band, as usual in textbooks


@lru_cache(maxsize=1024)
def chi_square_quantile(probability: float, degrees: float) -> float:
    if degrees == 1:
        from statistics import NormalDist

        return NormalDist().inv_cdf(0.5 * (1.0 + probability)) ** 2
    return 2.0 * gamma_quantile(degrees / 2.0, probability)


def mean_band(degrees: int, count: int | None = None) -> tuple[float, float]:
    """95 % band of a chi-square variable over its degrees of freedom (or over `count`)."""
    if not degrees:
        return (math.nan, math.nan)
    low, high = (1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0
    per = degrees if count is None else count
    return (chi_square_quantile(low, degrees) / per, chi_square_quantile(high, degrees) / per)


@dataclass(frozen=True, eq=False)
class Consistency:
    """Consistency figures of a run; a figure that the run does not allow is NaN."""

    samples: int  # number of samples with at least one measurement
    measurements: int  # number of measurements in these samples
    nis: float  # mean NIS per measurement; 1 is consistent, above is overconfident, below conservative
    # share of samples with NIS above the 95 % quantile of its chi-square distribution; 0.05 is consistent
    outside: float

    @property
    def nis_band(self) -> tuple[float, float]:
        """95 % band for `nis` of a consistent filter."""
        return mean_band(self.measurements)


class ConsistencyAccumulator:
    """Consistency of a run that arrives in chunks of consecutive samples, with constant memory."""

    def __init__(self) -> None:
        self.samples = self.measurements = self.above = 0
        self.nis_sum = 0.0

    def add(self, nis: np.ndarray, present: np.ndarray) -> None:
        """Add these fields of a filter's estimate over time, (n,)."""
        nis, present = np.asarray(nis, float), np.asarray(present, float)
        used = (present > 0.5) & np.isfinite(nis)
        degrees = present[used]
        self.samples += int(used.sum())
        self.measurements += int(degrees.sum())
        self.nis_sum += float(nis[used].sum())
        limits = {number: chi_square_quantile(CONFIDENCE, number) for number in np.unique(degrees).tolist()}
        self.above += int(sum((nis[used][degrees == number] > limit).sum() for number, limit in limits.items()))

    def result(self) -> Consistency:
        """The figures of all chunks so far."""
        return Consistency(
            self.samples,
            self.measurements,
            self.nis_sum / self.measurements if self.measurements else math.nan,
            self.above / self.samples if self.samples else math.nan,
        )


def nis_figures(found: Consistency, wide: bool = False) -> dict[str, float]:
    """Mean NIS, and its band for a consistent filter; none where it uses a larger variance on purpose (`wide`)."""
    figures = {"enabled_samples": float(found.samples), "nis_mean": found.nis}
    if wide:
        return figures
    low, high = found.nis_band
    return figures | {"nis_band_low": low, "nis_band_high": high, "nis_outside_95_share": found.outside}
