"""Courses: inputs of a car over time and distance, piece by piece, and the curves on which they are based."""

from __future__ import annotations

from typing import Annotated, NamedTuple, Protocol

import numpy as np

from tierod.core.fields import NOT_NEGATIVE

Columns = dict[str, np.ndarray]
"""Values by dotted name of `tierod_lab.ground.parts`: "road.curvature", "demand.speed", "wind.crosswind_speed"."""

FACTORS = frozenset(
    (
        "road.adhesion_left",
        "road.adhesion_right",
        "road.support",
        "demand.grip",
        "demand.attention",
    )
)
"""Columns whose default is one and that are multiplied when they are combined; all others add."""


class Start(NamedTuple):
    """Initial state of a run over a course."""

    speed: Annotated[float, "m/s", NOT_NEGATIVE] = 0.0


class Course(Protocol):
    """Inputs of a car and its driver, including road and wind."""

    @property
    def name(self) -> str:
        """Name for messages and provenance."""

    @property
    def duration(self) -> float:
        """Planned duration [s]."""

    @property
    def start(self) -> Start:
        """Initial state of a run."""

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants; missing ones have their defaults: level dry road, no wind, hands on the wheel.

        Args:
            time: instants [s]
            distance, speed: predicted distance along the path [m] and speed [m/s] of the car at these instants
            ahead: preview time of the driver for the curvature [s]
        """


def combine(columns: Columns, more: Columns) -> None:
    """Combine further columns with existing ones, in place; those of `FACTORS` are multiplied, all others added."""
    for name, values in more.items():
        if name not in columns:
            columns[name] = values
        elif name in FACTORS:
            columns[name] = columns[name] * values
        else:
            columns[name] = columns[name] + values


class Grid:
    """Table on equal steps, linear between its points and constant beyond its ends."""

    def __init__(self, step: float, columns: Columns):
        self.names, self._rate = tuple(columns), 1.0 / step
        table = np.column_stack([*columns.values()])
        self._last = len(table) - 1
        # The last row is repeated, so that the last point needs no special case in the interpolation.
        self._table = np.vstack([table, table[-1:]])

    def at(self, place: np.ndarray) -> Columns:
        """Every column at some places, in the unit of the step."""
        position = np.minimum(np.maximum(place * self._rate, 0.0), self._last)
        before = position.astype(np.intp)
        rows = self._table.take(before, axis=0)
        rows += (position - before)[:, None] * (self._table.take(before + 1, axis=0) - rows)
        return dict(zip(self.names, rows.T, strict=True))


KNOTS = 4096
"""Number of knots after which a random curve repeats: restlessness after 45 minutes, unevenness after 37 km."""


def smooth_noise(
    generator: np.random.Generator, shortest: float, longest: float, step: float, count: int = KNOTS
) -> np.ndarray:
    """A random curve on equal steps, with unit standard deviation at its knots.

    Args:
        shortest, longest: range of the knots' spacing [s] or [m]
    """
    knots = np.concatenate([[0.0], np.cumsum(generator.uniform(shortest, longest, count))])
    values = generator.standard_normal(count)
    place = np.arange(0.0, knots[-1], step)
    before = np.searchsorted(knots, place, side="right") - 1
    share = (place - knots[before]) / (knots[before + 1] - knots[before])
    share *= share * (3.0 - 2.0 * share)
    following = np.roll(values, -1)
    return np.asarray(values[before] + share * (following[before] - values[before]))


class Repeated:
    """A curve on equal steps that repeats itself, read at any place."""

    def __init__(self, values: np.ndarray, step: float):
        self._values, self._rate = values, 1.0 / step

    def at(self, place: np.ndarray) -> np.ndarray:
        """The curve at some places, linear between its points."""
        position = place * self._rate
        before = np.floor(position).astype(np.intp)
        lower = self._values.take(before, mode="wrap")
        return np.asarray(lower + (position - before) * (self._values.take(before + 1, mode="wrap") - lower))


def band_limited(
    generator: np.random.Generator, lowest: float, highest: float, seconds: float, step: float
) -> np.ndarray:
    """A random curve on equal steps, of unit standard deviation and constant power density within a band.

    Args:
        lowest, highest: limits of the band [Hz]
        seconds: duration [s]
        step: spacing [s]
    """
    count = round(seconds / step) + 1
    frequency = np.fft.rfftfreq(count, step)
    inside = (frequency >= lowest) & (frequency <= highest)
    spectrum = inside * np.exp(2j * np.pi * generator.random(len(frequency)))
    curve = np.fft.irfft(spectrum, count)
    return curve / np.std(curve)
