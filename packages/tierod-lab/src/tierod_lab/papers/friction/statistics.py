"""Statistics of groups of drives: means, standard deviations, and the separation of two groups."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from tierod_lab.papers.friction.digest import Digest

BINS = 40  # Number of bins of the histograms whose overlap is measured


def pooled(digests: Iterable[Digest], estimator: str) -> np.ndarray:
    """Settled estimates of all drives in one array [N*m]."""
    return joined(each.settled(estimator) for each in digests)


def joined(parts: Iterable[np.ndarray]) -> np.ndarray:
    """All values in one array."""
    return np.concatenate([np.zeros(0), *parts])


def means(digests: Iterable[Digest], estimator: str) -> np.ndarray:
    """Mean estimate of each drive [N*m]; NaN where the estimator was not enabled for long enough."""
    return np.array([each.mean(estimator) for each in digests])


def mean(values: np.ndarray) -> float:
    """Mean; NaN without values."""
    return float(values.mean()) if len(values) else math.nan


def deviation(values: np.ndarray) -> float:
    """Standard deviation with divisor n; NaN without values."""
    return float(values.std()) if len(values) else math.nan


def plus_minus(values: np.ndarray, truth: float = 0.0) -> str:
    """Bias (mean less truth) and standard deviation as text for a table."""
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
    # The margins keep the largest value inside the last bin despite rounding, and the bins wide where all are equal.
    if logarithmic:
        return np.geomspace(max(low, 1e-9), max(high, low + 1e-9) * (1.0 + 1e-9), bins + 1)
    return np.linspace(low, high + 1e-9 + 1e-9 * abs(high), bins + 1)


def shares(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Share of the values in every bin [-]; the bins have the edges `at`."""
    counts = np.histogram(values, at)[0]
    return counts / max(len(values), 1)


def overlap(one: np.ndarray, other: np.ndarray, *, logarithmic: bool = False) -> float:
    """Overlap of the histograms of two groups: 0 disjoint, 1 identical; NaN where a group is empty."""
    if not (len(one) and len(other)):
        return math.nan
    at = edges(one, other, logarithmic=logarithmic)
    return float(np.minimum(shares(one, at), shares(other, at)).sum())


def on_right_side(low: np.ndarray, high: np.ndarray, threshold: float) -> float:
    """Balanced accuracy of a threshold: mean over both groups of the share on their side; NaN where one is empty."""
    if not (len(low) and len(high)):
        return math.nan
    return 0.5 * (float(np.mean(low < threshold)) + float(np.mean(high > threshold)))


def best_accuracy(low: np.ndarray, high: np.ndarray) -> float:
    """Balanced accuracy at the best threshold; NaN where a group is empty."""
    if not (len(low) and len(high)):
        return math.nan
    low, high = np.sort(low), np.sort(high)
    at = np.concatenate([low, high])
    below = np.searchsorted(low, at, side="right") / len(low)
    above = 1.0 - np.searchsorted(high, at, side="right") / len(high)
    return float(np.max(0.5 * (below + above)))
