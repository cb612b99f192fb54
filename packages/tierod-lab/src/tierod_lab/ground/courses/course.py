"""Courses: inputs of a car over time and distance, their curves, and conditions of road, wind and hands."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, ClassVar, NamedTuple, Protocol

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE

Columns = dict[str, np.ndarray]
"""Values by dotted name of `tierod_lab.ground.parts`: "road.curvature", "demand.speed", "wind.crosswind_speed"."""
FACTORS = frozenset(("road.adhesion_left", "road.adhesion_right", "road.support", "demand.grip", "demand.attention"))
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
        if name in columns:
            values = columns[name] * values if name in FACTORS else columns[name] + values
        columns[name] = values


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
    """A random curve on equal steps, with unit standard deviation at knots that are so far apart [s] or [m]."""
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
    """A random curve over a time [s] on equal steps [s], with unit deviation and constant power within a band [Hz]."""
    count = round(seconds / step) + 1
    frequency = np.fft.rfftfreq(count, step)
    inside = (frequency >= lowest) & (frequency <= highest)
    spectrum = inside * np.exp(2j * np.pi * generator.random(len(frequency)))
    curve = np.fft.irfft(spectrum, count)
    return curve / np.std(curve)


@dataclass(frozen=True)
class During:
    """Time window of a condition, with smooth fading; the whole drive by default."""

    start: Annotated[float, "s", ANY] = -math.inf
    end: Annotated[float, "s", ANY] = math.inf
    ramp: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    every: Annotated[float, "s", POSITIVE] = math.inf

    _unit: ClassVar[str] = "s"

    def __post_init__(self) -> None:
        if not self.start < self.end:
            window = f"a window from {self.start:g} to {self.end:g} {self._unit}"
            raise ParameterError(f"{window} is empty; let its end come after its start")

    def share(self, time: np.ndarray, distance: np.ndarray) -> np.ndarray | float | None:
        return self._share(time)

    def _share(self, place: np.ndarray) -> np.ndarray | float | None:
        start, end = self.start, self.end
        if self.every < math.inf:
            first = start if start > -math.inf else 0.0
            place = np.where(place < start, place, first + np.mod(place - first, self.every))
        # Places ascend within a piece, so its ends suffice to see that it lies outside the window.
        elif place[-1] < start or place[0] > end:
            return None
        elif start == -math.inf and end == math.inf:
            return 1.0
        if self.ramp == 0.0:
            return ((place >= start) & (place < end)).astype(float)
        inside = np.minimum(np.minimum(place - start, end - place) / self.ramp, 1.0)
        inside = np.maximum(inside, 0.0)
        return inside * inside * (3.0 - 2.0 * inside)


@dataclass(frozen=True)
class Along(During):
    """Window of a condition along the path, with smooth fading."""

    start: Annotated[float, "m", ANY] = -math.inf
    end: Annotated[float, "m", ANY] = math.inf
    ramp: Annotated[float, "m", NOT_NEGATIVE] = 0.0
    every: Annotated[float, "m", POSITIVE] = math.inf

    _unit = "m"

    def share(self, time: np.ndarray, distance: np.ndarray) -> np.ndarray | float | None:
        return self._share(distance)


Window = During | Along


Acting = Callable[[np.ndarray, np.ndarray], Columns]
"""(instants [s], distances [m]) -> columns that are combined with those of the course."""


@dataclass(frozen=True)
class _Steady:
    window: Window = field(default_factory=During)

    _usual = 0.0
    _columns: ClassVar[dict[str, str]]  # field -> column that it sets

    def acting(self, generator: np.random.Generator) -> Acting:
        levels, usual = {column: getattr(self, name) for name, column in self._columns.items()}, self._usual

        def act(time: np.ndarray, distance: np.ndarray) -> Columns:
            share = self.window.share(time, distance)
            if share is None:
                return {}
            around = np.full(len(time), usual)
            return {name: around + share * (level - usual) for name, level in levels.items()}

        return act


class _Share(_Steady):
    _usual = 1.0


@dataclass(frozen=True)
class Adhesion(_Share):
    """A road with less adhesion than dry asphalt, on both sides or on one."""

    left: Annotated[float, "", SHARE] = 1.0
    right: Annotated[float, "", SHARE] = 1.0

    _columns: ClassVar = {"left": "road.adhesion_left", "right": "road.adhesion_right"}


@dataclass(frozen=True)
class Slope(_Steady):
    """A road that is not level."""

    bank: Annotated[float, "rad", ANY] = 0.0
    grade: Annotated[float, "rad", ANY] = 0.0

    _columns: ClassVar = {"bank": "road.bank_angle", "grade": "road.grade_angle"}


@dataclass(frozen=True)
class Breeze(_Steady):
    """Steady wind."""

    crosswind: Annotated[float, "m/s", ANY] = 0.0
    headwind: Annotated[float, "m/s", ANY] = 0.0

    _columns: ClassVar = {"crosswind": "wind.crosswind_speed", "headwind": "wind.headwind_speed"}


@dataclass(frozen=True)
class HandTorque(_Steady):
    """Torque of the hands in addition to that of the arms."""

    torque: Annotated[float, "N*m", ANY] = 0.0

    _columns: ClassVar = {"torque": "demand.hand_torque"}


@dataclass(frozen=True)
class Grip(_Share):
    """Grip of the hands on the wheel."""

    share: Annotated[float, "", SHARE] = 0.0  # share of the arms' stiffness and damping; 0 is hands off

    _columns: ClassVar = {"share": "demand.grip"}


@dataclass(frozen=True)
class Attention(_Share):
    """Attention of the driver to the lane."""

    share: Annotated[float, "", SHARE] = 0.0  # share of the lateral offset that the driver corrects; 0 is inattentive

    _columns: ClassVar = {"share": "demand.attention"}


@dataclass(frozen=True)
class _Random:
    window: Window = field(default_factory=During)

    _column: ClassVar[str]

    def _within(self, values: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Acting:
        def act(time: np.ndarray, distance: np.ndarray) -> Columns:
            share = self.window.share(time, distance)
            return {} if share is None else {self._column: share * values(time, distance)}

        return act


@dataclass(frozen=True)
class _Wandering(_Random):
    deviation: float = 0.0
    shortest: float = 0.0
    longest: float = 0.0

    _step: ClassVar[float]
    _over_distance: ClassVar[bool] = False

    def acting(self, generator: np.random.Generator) -> Acting:
        noise = smooth_noise(generator, self.shortest, self.longest, self._step)
        curve = Repeated(self.deviation * noise, self._step)
        return self._within(lambda time, distance: curve.at(distance if self._over_distance else time))


@dataclass(frozen=True)
class Restlessness(_Wandering):
    """Small unnecessary steering corrections, as human drivers make them all the time."""

    deviation: Annotated[float, "rad", NOT_NEGATIVE] = 0.025
    shortest: Annotated[float, "s", POSITIVE] = 0.4
    longest: Annotated[float, "s", POSITIVE] = 1.0

    _column, _step = "demand.steering_wheel_angle", 0.02


@dataclass(frozen=True)
class Tremor(_Random):
    """Tremor of the hands: a torque near one frequency with random amplitude."""

    deviation: Annotated[float, "N*m", NOT_NEGATIVE] = 0.05
    frequency: Annotated[float, "Hz", POSITIVE] = 9.0

    _column = "demand.hand_torque"

    def acting(self, generator: np.random.Generator) -> Acting:
        rate, step = 2.0 * math.pi * self.frequency, 0.05
        sine = Repeated(self.deviation * smooth_noise(generator, 0.3, 1.0, step), step)
        cosine = Repeated(self.deviation * smooth_noise(generator, 0.3, 1.0, step), step)

        def torque(time: np.ndarray, distance: np.ndarray) -> np.ndarray:
            return np.asarray(sine.at(time) * np.sin(rate * time) + cosine.at(time) * np.cos(rate * time))

        return self._within(torque)


@dataclass(frozen=True)
class Gusts(_Wandering):
    """Random gusts of wind across the road."""

    deviation: Annotated[float, "m/s", NOT_NEGATIVE] = 2.0
    shortest: Annotated[float, "s", POSITIVE] = 0.7
    longest: Annotated[float, "s", POSITIVE] = 4.0

    _column, _step = "wind.crosswind_speed", 0.05


@dataclass(frozen=True)
class Unevenness(_Wandering):
    """Waves and ruts: random variation of the road's crossfall over a few metres."""

    deviation: Annotated[float, "rad", NOT_NEGATIVE] = 0.004
    shortest: Annotated[float, "m", POSITIVE] = 3.0
    longest: Annotated[float, "m", POSITIVE] = 15.0

    _column, _step = "road.bank_angle", 0.5
    _over_distance = True


AnyCondition = Adhesion | Slope | Breeze | HandTorque | Grip | Attention | Restlessness | Tremor | Gusts | Unevenness
