"""What is remembered of a faulty sensor while the kinds of its fault are weighed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from tierod.graph.maths import maximum, minimum, sqrt, where


class Fit(NamedTuple):
    """One parameter learnt from readings, and how likely the readings were on the way."""

    value: Any
    variance: Any
    score: Any


class SlopeFit(NamedTuple):
    """Start and slope learnt from readings, and how likely the readings were on the way."""

    start: Any
    slope: Any
    start_variance: Any
    covariance: Any
    slope_variance: Any
    score: Any


class KindState(NamedTuple):
    """What is remembered of one sensor.

    Args:
        seen: samples with a reading since the declaration
        last: reading of the sample before
        repeated: whether every reading since the declaration was the same
        constant, offset, gain: fits of one parameter
        drift: fit of a slope
        weight, power, expected: sum of weights, mean squared deviation, and what it would be without fault
        noise: how likely the readings were as noise
        delays: how likely the readings were with each of `DELAYS`
        past: predictions, one line for each delay
    """

    seen: Any
    last: Any
    repeated: Any
    constant: Fit
    offset: Fit
    gain: Fit
    drift: SlopeFit
    weight: Any
    power: Any
    expected: Any
    noise: Any
    delays: tuple[Any, ...]
    past: tuple[Any, ...]


def parts(fit: Fit) -> tuple[Any, Any, Any]:
    """Score, value, standard deviation."""
    return fit.score, fit.value, sqrt(fit.variance)


def parabola(times: Sequence[Any], scores: Sequence[Any]) -> tuple[Any, Any]:
    """Place of the highest point between three times, and the width of its curvature."""
    left, right = times[1] - times[0], times[2] - times[1]
    down, up = (scores[1] - scores[0]) / left, (scores[2] - scores[1]) / right
    bend = minimum((up - down) / (0.5 * (left + right)), -1e-9)
    slope = (down * right + up * left) / (left + right)
    peak = times[1] - slope / bend
    return minimum(maximum(peak, times[0]), times[2]), minimum(1.0 / sqrt(-bend), times[2] - times[0])


def selected(condition: Any, first: KindState, second: KindState) -> KindState:
    """One of two states, their delay lines left alone."""

    def pick(a: Any, b: Any) -> Any:
        if isinstance(a, tuple):
            picked = [pick(x, y) for x, y in zip(a, b, strict=True)]
            return type(a)(*picked) if hasattr(a, "_fields") else tuple(picked)
        return where(condition, a, b)

    lines = first.past
    picked: KindState = pick(first._replace(past=()), second._replace(past=()))
    return picked._replace(past=lines)
