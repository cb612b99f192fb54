"""Traces of a session that are results with a band, and their differences between sessions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

AFTER, BEFORE = "_standard_deviation", "deviation_of_"


class Pair(NamedTuple):
    """Names of two traces: a result, and its standard deviation."""

    value: str
    deviation: str


def pairs_of(names: Iterable[str]) -> tuple[Pair, ...]:
    """Results of a session that have a band: first the names with `AFTER`, then those with `BEFORE`.

    Args:
        names: names of its traces
    """
    ordered = list(names)
    known = set(ordered)
    after = [Pair(name, f"{name}{AFTER}") for name in ordered if f"{name}{AFTER}" in known]
    before = [Pair(name, f"{BEFORE}{name}") for name in ordered if f"{BEFORE}{name}" in known]
    return (*after, *before)


def moved(shown: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Difference of a trace between another session and this one, (n,); 0 where one of them is missing."""
    difference: np.ndarray = other[name] - shown[name]
    return np.where(np.isfinite(difference), difference, 0.0)


def widened(
    shown: Mapping[str, np.ndarray], variances: Mapping[str, np.ndarray], pairs: Iterable[Pair]
) -> dict[str, np.ndarray]:
    """Traces with wider bands.

    Args:
        shown: traces by name, (n,) each
        variances: variances to be added, by name of the value, (n,) each
        pairs: results whose bands are widened, if there is a variance for them
    """
    wide = dict(shown)
    for value, deviation in pairs:
        if value in variances:
            wide[deviation] = np.sqrt(shown[deviation] ** 2 + variances[value])
    return wide
