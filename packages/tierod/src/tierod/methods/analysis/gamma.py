"""Quantiles of the gamma distribution without SciPy's special functions, whose import takes half a second."""

from __future__ import annotations

import math
import sys
from statistics import NormalDist

STEPS = 60
"""Largest number of steps of Newton's method and bisection; six are usual."""

TERMS = 10_000
"""Largest number of terms of a series, which grows with the square root of the shape."""

MOST_SHAPE = 1e6
"""Shape up to which the series are summed; above, the error of Wilson and Hilferty's cube root is below rounding."""


def lower_gamma(shape: float, x: float) -> float:
    """Regularised lower incomplete gamma function P(shape, x): distribution function of a gamma variable.

    Args:
        shape: > 0, up to `MOST_SHAPE`
        x: >= 0

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

    Args:
        shape: > 0
        probability: between 0 and 1, both excluded

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
