"""Figures of groups of drives: means, spreads, and how well two groups are separated."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from tierod.papers.friction.digest import Digest

BINS = 40
"""Bins of the histograms whose overlap is measured."""


def pooled(digests: Iterable[Digest], estimator: str) -> np.ndarray:
    """The settled estimates of all drives together [N*m]."""
    return joined(each.settled(estimator) for each in digests)


def joined(parts: Iterable[np.ndarray]) -> np.ndarray:
    """All values in one array."""
    return np.concatenate([np.zeros(0), *parts])


def means(digests: Iterable[Digest], estimator: str) -> np.ndarray:
    """The mean estimate of each drive [N*m]; NaN where the gate never opened long enough."""
    return np.array([each.mean(estimator) for each in digests])


def mean(values: np.ndarray) -> float:
    """Mean; NaN of nothing."""
    return float(values.mean()) if len(values) else math.nan


def deviation(values: np.ndarray) -> float:
    """Standard deviation of the values as they are; NaN of nothing."""
    return float(values.std()) if len(values) else math.nan


def plus_minus(values: np.ndarray, truth: float = 0.0) -> str:
    """Mean less truth, and standard deviation, as tables show them."""
    if not len(values):
        return "none"
    sign = "+" if truth else ""
    return f"{mean(values) - truth:{sign}.2f} ± {deviation(values):.2f}"


def edges(*groups: np.ndarray, bins: int = BINS, logarithmic: bool = False) -> np.ndarray:
    """Edges of common bins over all values."""
    values = joined(groups)
    if not len(values):
        return np.array([0.0, 1.0])
    low, high = float(values.min()), float(values.max())
    if logarithmic:
        return np.geomspace(max(low, 1e-9), max(high, low + 1e-9) * (1.0 + 1e-9), bins + 1)
    return np.linspace(low, high + 1e-9 + 1e-9 * abs(high), bins + 1)


def shares(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Share of the values between each two edges."""
    counts = np.histogram(values, at)[0]
    return counts / max(len(values), 1)


def overlap(one: np.ndarray, other: np.ndarray, *, logarithmic: bool = False) -> float:
    """Share that the histograms of two groups have in common: 0 apart, 1 the same; NaN where one is empty."""
    if not (len(one) and len(other)):
        return math.nan
    at = edges(one, other, logarithmic=logarithmic)
    return float(np.minimum(shares(one, at), shares(other, at)).sum())


def on_right_side(low: np.ndarray, high: np.ndarray, threshold: float) -> float:
    """Share of the values on their side of a threshold, both groups weighing the same; NaN where one is empty."""
    if not (len(low) and len(high)):
        return math.nan
    return 0.5 * (float(np.mean(low < threshold)) + float(np.mean(high > threshold)))


def best_accuracy(low: np.ndarray, high: np.ndarray) -> float:
    """The same at the threshold that parts the groups best."""
    if not (len(low) and len(high)):
        return math.nan
    low, high = np.sort(low), np.sort(high)
    at = np.concatenate([low, high])
    below = np.searchsorted(low, at, side="right") / len(low)
    above = 1.0 - np.searchsorted(high, at, side="right") / len(high)
    return float(np.max(0.5 * (below + above)))
