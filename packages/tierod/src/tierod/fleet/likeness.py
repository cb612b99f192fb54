"""Detection of recordings of the same drive in different files: mean and standard deviation of every signal agree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

import numpy as np

from tierod.core.recording import Recording

TEMPERATURE = "ambient_temperature"
"""Ambient temperature, which is not compared: it hardly varies, so that rounding changes its moments."""

LEAST_SIGNALS = 3  # Smallest number of common signals; fewer agree by chance

TOLERANCE = 5e-4
"""Tolerance of the moments in standard deviations of the signal.

Rounding to a logger's resolution changes less; pure noise, of a car that stands for ten minutes, agrees to .004.
"""

MINUTE: Annotated[float, "s"] = 60.0  # Tolerance of the start times; the clocks of two loggers differ by less


class Moments:
    """Mean and standard deviation of every signal of a recording, accumulated piece by piece."""

    def __init__(self) -> None:
        self._sums: dict[str, np.ndarray] = {}

    def add(self, piece: Recording) -> None:
        for name, channel in piece.channels.items():
            values = channel.values
            values = values if np.isfinite(values.sum()) else values[np.isfinite(values)]
            if len(values):
                first, count, total, squares = self._sums.get(name, (values[0], 0.0, 0.0, 0.0))
                # Sums about the first value: a mean far from zero costs no digits of the standard deviation.
                offsets = values - first
                total += offsets.sum()
                sums = (first, count + len(values), total, squares + np.square(offsets, out=offsets).sum())
                self._sums[name] = np.array(sums)

    def of(self, name: str) -> tuple[float, float] | None:
        """Mean and standard deviation of a signal; None if it has no value."""
        if name not in self._sums:
            return None
        first, count, total, squares = map(float, self._sums[name])
        return first + total / count, max(squares / count - (total / count) ** 2, 0.0) ** 0.5

    @property
    def moments(self) -> dict[str, list[float]]:
        """Mean and standard deviation of every signal that varies, without the ambient temperature, for the ledger."""
        found = {name: self.of(name) for name in sorted(self._sums) if name != TEMPERATURE}
        return {name: list(pair) for name, pair in found.items() if pair and pair[1] > 0.0}


def alike(rows: Sequence[Mapping[str, Any]]) -> Iterator[tuple[int, int]]:
    """Pairs of recordings that hold the same drive, as pairs of indices, the earlier first."""
    cars: dict[str, list[int]] = {}
    for place, row in enumerate(rows):
        cars.setdefault(row["vehicle"], []).append(place)
    for places in cars.values():
        yield from _of_car(rows, places)


def _of_car(rows: Sequence[Mapping[str, Any]], places: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Pairs among the recordings that have the most common signals, then among the remaining ones."""
    while usual := _usual([rows[place].get("moments") or {} for place in places]):
        having = [place for place in places if _has(rows[place], usual)]
        for pair in _near(np.array([_features(rows[place], usual) for place in having])):
            first, second = (rows[having[at]] for at in pair)
            common = sorted({*first["moments"]} & {*second["moments"]})
            apart = np.subtract(_features(first, common), _features(second, common))
            if np.all(np.abs(apart) < 1.0) and _begin_together(first.get("start"), second.get("start")):
                yield having[pair[0]], having[pair[1]]
        places = [place for place in places if not _has(rows[place], usual)]


def _usual(moments: Sequence[Mapping[str, Any]]) -> list[str]:
    """Signals that many recordings share: the most common, then the most common together with it; empty if too few."""
    left, usual = [each for each in moments if len(each) >= LEAST_SIGNALS], list[str]()
    while left and len(usual) < LEAST_SIGNALS:
        counts = Counter(name for each in left for name in each if name not in usual)
        usual.append(min(counts, key=lambda name: (-counts[name], name)))
        left = [each for each in left if usual[-1] in each]
    return usual


def _has(row: Mapping[str, Any], names: Sequence[str]) -> bool:
    return {*names} <= {*(row.get("moments") or ())}


def _begin_together(one: float | None, other: float | None) -> bool:
    return one is None or other is None or abs(one - other) < MINUTE


def _features(row: Mapping[str, Any], signals: Sequence[str]) -> list[float]:
    """Duration and moments, scaled so that those of the same drive differ by less than 1 each."""
    pairs = [row["moments"][name] for name in signals]
    ratios = [mean / deviation for mean, deviation in pairs] + [np.log(deviation) for _, deviation in pairs]
    return [row["duration_s"], *(np.array(ratios) / TOLERANCE)]


def _near(features: np.ndarray) -> list[tuple[int, int]]:
    if len(features) < 2:
        return []
    from scipy.spatial import KDTree

    return sorted(KDTree(features).query_pairs(1.0, p=np.inf))
