"""Courses: inputs of a car over time and distance, piece by piece; and the curves that they come from."""

from __future__ import annotations

from typing import Annotated, NamedTuple, Protocol

import numpy as np

from tierod.core.fields import NOT_NEGATIVE

Columns = dict[str, np.ndarray]
"""Values by dotted name of `tierod.proving_ground.parts`: "road.curvature", "demand.speed", "wind.crosswind_speed"."""

FACTORS = frozenset(
    (
        "road.adhesion_left",
        "road.adhesion_right",
        "road.support",
        "demand.grip",
        "demand.attention",
    )
)
"""Columns that are one where nothing is said, and that multiply where several things are said; all others add."""


class Start(NamedTuple):
    """Start of a run over a course.

    Args:
        speed: rolling straight ahead
    """

    speed: Annotated[float, "m/s", NOT_NEGATIVE] = 0.0


class Course(Protocol):
    """Demand on a car and its driver, and the road and air around them."""

    @property
    def name(self) -> str:
        """For messages and provenance."""

    @property
    def duration(self) -> float:
        """Duration as planned [s]."""

    @property
    def start(self) -> Start:
        """Start of a run."""

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants; what is left out is as usual: flat dry road, no wind, hands on the wheel.

        Args:
            time: instants [s]
            distance, speed: of the car along the path, as foreseen for these instants [m], [m/s]
            ahead: time by which the driver reads the curvature earlier [s]
        """


def combine(columns: Columns, more: Columns) -> None:
    """Add what else acts to columns that are there already, in place; shares are multiplied."""
    for name, values in more.items():
        if name not in columns:
            columns[name] = values
        elif name in FACTORS:
            columns[name] = columns[name] * values
        else:
            columns[name] = columns[name] + values


class Grid:
    """Straight between its points, constant beyond its ends."""

    def __init__(self, step: float, columns: Columns):
        """Columns [one value per point] at 0, step, 2 step, ..."""
        self.names, self._rate = tuple(columns), 1.0 / step
        table = np.column_stack([*columns.values()])
        self._last = len(table) - 1
        self._table = np.vstack([table, table[-1:]])

    def at(self, place: np.ndarray) -> Columns:
        """Every column at some places, in seconds or metres like the step."""
        position = np.minimum(np.maximum(place * self._rate, 0.0), self._last)
        before = position.astype(np.intp)
        rows = self._table.take(before, axis=0)
        rows += (position - before)[:, None] * (self._table.take(before + 1, axis=0) - rows)
        return dict(zip(self.names, rows.T, strict=True))


KNOTS = 4096
"""After so many knots a curve comes again: restlessness after three quarters of an hour, unevenness after 37 km."""


def smooth_noise(
    generator: np.random.Generator, shortest: float, longest: float, step: float, count: int = KNOTS
) -> np.ndarray:
    """A random curve of standard deviation one at its knots, on equal steps.

    Args:
        generator: source of chance
        shortest, longest: spacing of the knots, seconds or metres
        step: spacing of the result, in the same unit
        count: number of knots
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
    """A curve on equal steps, read anywhere, beginning anew after its end."""

    def __init__(self, values: np.ndarray, step: float):
        self._values, self._rate = values, 1.0 / step

    def at(self, place: np.ndarray) -> np.ndarray:
        """The curve at some places, straight between its points."""
        position = place * self._rate
        before = np.floor(position).astype(np.intp)
        lower = self._values.take(before, mode="wrap")
        return np.asarray(lower + (position - before) * (self._values.take(before + 1, mode="wrap") - lower))


def band_limited(
    generator: np.random.Generator, lowest: float, highest: float, seconds: float, step: float
) -> np.ndarray:
    """A random curve of standard deviation one whose power is spread evenly over a band, on equal steps.

    Args:
        generator: source of chance
        lowest, highest: frequencies [Hz]
        seconds: length [s]
        step: spacing [s]
    """
    count = round(seconds / step) + 1
    frequency = np.fft.rfftfreq(count, step)
    inside = (frequency >= lowest) & (frequency <= highest)
    spectrum = inside * np.exp(2j * np.pi * generator.random(len(frequency)))
    curve = np.fft.irfft(spectrum, count)
    return curve / np.std(curve)
