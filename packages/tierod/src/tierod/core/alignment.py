"""Resampling of channels on a uniform time grid: the latest sample is held, or neighbours are interpolated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Places(NamedTuple):
    """Positions of the times of a grid among the time stamps of a channel, (n,) each."""

    before: np.ndarray | slice  # indices of the latest samples up to the times of the grid
    known: np.ndarray | bool
    age: np.ndarray  # time since that sample [s]
    held: np.ndarray  # whether the sample is recent enough to be held
    everywhere: bool
    rounding: float  # amount by which a stamp may lie after its time of the grid [s]


def places(time: np.ndarray, grid: np.ndarray, maximum_age: float, tolerance: float) -> Places:
    """Positions of the times of a grid among the time stamps of a channel.

    Args:
        time: stamps [s], not decreasing
        grid: times [s]
        maximum_age: age up to which a sample is held [s]
        tolerance: amount by which a stamp may lie after its time of the grid, at most a microsecond [s]
    """
    rounding = min(tolerance, 1e-6)
    until = grid + rounding
    known: np.ndarray | bool = True
    # With regular clocks a slice takes the samples without a search and without a copy.
    before: np.ndarray | slice | None = _evenly_spaced(time, until)
    if before is None:
        found = np.searchsorted(time, until, side="right") - 1
        known, before = found >= 0, np.maximum(found, 0)
    age = grid - time[before]
    held = known & (age <= maximum_age + rounding)
    return Places(before, known, age, held, bool(held.all()), rounding)


def _evenly_spaced(time: np.ndarray, until: np.ndarray) -> slice | None:
    """Slice of the last stamps up to given times, where these are every k-th stamp (regular clocks); else None."""
    if len(until) < 2:
        return None
    first, last = (np.searchsorted(time, until[[0, -1]], side="right") - 1).tolist()
    step, rest = divmod(last - first, len(until) - 1)
    if first < 0 or step < 1 or rest:
        return None
    before, following = slice(first, last + 1, step), time[first + 1 : last + 2 : step]
    fits = (time[before] <= until).all() and (following > until[: len(following)]).all()
    return before if fits else None


def held(values: np.ndarray, places: Places) -> np.ndarray:
    """The latest sample at each time of a grid; NaN where it is too old."""
    latest = values[places.before]
    return latest if places.everywhere else np.where(places.held, latest, np.nan)


def between(time: np.ndarray, values: np.ndarray, places: Places, maximum_age: float) -> np.ndarray:
    """Linear interpolation at each time of a grid; NaN where the two samples are too far apart.

    Args:
        time, values: stamps [s] and samples of the channel
        maximum_age: largest distance of two samples that are interpolated [s]
    """
    before, known, age, _, _, rounding = places
    before = np.arange(len(time))[before]
    after = np.minimum(before + 1, len(time) - 1)
    width = time[after] - time[before]
    share = np.divide(age, width, out=np.zeros_like(age), where=width > 0.0)
    between = values[before] + np.clip(share, 0.0, 1.0) * (values[after] - values[before])
    exact = age <= rounding
    within = (width <= maximum_age + rounding) & (age <= width + rounding)
    return np.where(known & exact, values[before], np.where(known & within & (width > 0.0), between, np.nan))
