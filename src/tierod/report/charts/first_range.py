"""Which heights of a chart are shown at first."""

from __future__ import annotations

import numpy as np


def first_range(mean: np.ndarray, upper: np.ndarray, outer: np.ndarray, levels: list[float]) -> list[float]:
    """Lowest and highest value shown at first.

    Args:
        mean, upper: of the line, mean and highest of every bin
        outer: upper end of its band
        levels: that are drawn across
    """
    return _both_ways(mean, levels) if _has_both_signs(mean) else _top(upper, outer, levels)


def _top(upper: np.ndarray, outer: np.ndarray, levels: list[float]) -> list[float]:
    """The range shown at first: all levels, and the band less its start, wide until something is learnt."""
    seen = np.concatenate([upper[np.isfinite(upper)], outer[np.isfinite(outer)]])
    high = max([*levels, float(np.quantile(seen, 0.98)) if len(seen) else 1.0])
    low = min(0.0, float(np.quantile(upper[np.isfinite(upper)], 0.02)) if np.isfinite(upper).any() else 0.0)
    return [1.1 * low, 1.15 * high or 1.0]


def _has_both_signs(mean: np.ndarray) -> bool:
    """Whether a tenth of what is known lies below zero; a slip below it makes no range."""
    known = mean[np.isfinite(mean)]
    return bool(np.mean(known < 0.0) > 0.1) if len(known) else False


def _both_ways(mean: np.ndarray, levels: list[float]) -> list[float]:
    """The range shown at first of what has both signs: all of the line, and all levels."""
    low, high = np.nanmin(mean), max([*levels, np.nanmax(mean)])
    room = 0.08 * (high - low)
    return [float(low - room), float(high + room)]
