"""Closed circuits of straights and bends, given or drawn at random."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod_lab.ground.courses.base import Described, WayCourse
from tierod_lab.ground.courses.conditions import Adhesion, Along, AnyCondition, Gusts, Slope, Unevenness
from tierod_lab.ground.courses.course import Columns, Start
from tierod_lab.ground.courses.way import STEP, Pace, Way


@dataclass(frozen=True)
class Straight:
    """A straight section."""

    length: Annotated[float, "m", POSITIVE]
    speed: Annotated[float, "m/s", POSITIVE] = math.inf

    @property
    def curvature(self) -> float:
        return 0.0


@dataclass(frozen=True)
class Bend:
    """A circular section."""

    radius: Annotated[float, "m", POSITIVE]
    turn: Annotated[float, "rad", ANY]
    speed: Annotated[float, "m/s", POSITIVE] = math.inf

    @property
    def length(self) -> float:
        return self.radius * abs(self.turn)

    @property
    def curvature(self) -> float:
        return math.copysign(1.0 / self.radius, self.turn)


@dataclass(frozen=True)
class Halt:
    """A stop on the way."""

    place: Annotated[float, "m", POSITIVE]
    time: Annotated[float, "s", NOT_NEGATIVE] = 3.0


@dataclass(frozen=True)
class Circuit(WayCourse):
    """A closed circuit, driven lap after lap; its sections are joined by clothoids."""

    sections: tuple[Straight | Bend, ...] = ()
    transition: Annotated[float, "m", POSITIVE] = 4.0
    time: Annotated[float, "s", POSITIVE] = 200.0
    speed: Annotated[float, "m/s", POSITIVE] = 10.0
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 4.0
    wait: Annotated[float, "s", NOT_NEGATIVE] = 2.0
    halts: tuple[Halt, ...] = ()

    def __post_init__(self) -> None:
        if not self.sections:
            raise ParameterError("a circuit needs sections; give straights and bends")
        places = [0.0, *(halt.place for halt in self.halts), self.length]
        if not all(before < after for before, after in pairwise(places)):
            raise ParameterError(
                f"halts lie within the {self.length:g} m of a circuit, one after the other, not at {places[1:-1]} m"
            )

    @property
    def duration(self) -> float:
        return self.time

    @cached_property
    def length(self) -> float:
        return sum(section.length for section in self.sections)

    @cached_property
    def lap(self) -> tuple[np.ndarray, np.ndarray]:
        """Curvature [1/m] and speed limit [m/s] of one lap, on a whole number of equal steps."""
        count = math.ceil(self.length / STEP)
        place = np.arange(count) * self.length / count
        ends = np.cumsum([section.length for section in self.sections])
        turned = np.cumsum([section.length * section.curvature for section in self.sections])
        corners, headings = np.concatenate([[0.0], ends]), np.concatenate([[0.0], turned])
        return self._smoothed(place, corners, headings), self._limits(place, ends)

    def _smoothed(self, place: np.ndarray, corners: np.ndarray, headings: np.ndarray) -> np.ndarray:

        def heading(where: np.ndarray) -> np.ndarray:
            laps = np.floor(where / self.length)
            return np.asarray(laps * headings[-1] + np.interp(where - laps * self.length, corners, headings))

        half = 0.5 * self.transition
        return np.asarray((heading(place + half) - heading(place - half)) / self.transition)

    def _limits(self, place: np.ndarray, ends: np.ndarray) -> np.ndarray:
        section = np.minimum(np.searchsorted(ends, place, side="right"), len(ends) - 1)
        return np.asarray(np.minimum(np.array([each.speed for each in self.sections])[section], self.speed))

    @cached_property
    def way(self) -> Way:
        curvature, limit = self.lap
        step = self.length / len(curvature)
        laps = math.ceil(self.time * float(np.max(limit)) / self.length) + 1
        lateral = np.full(laps * len(curvature), self.lateral_acceleration)
        stops = [(0.0, self.wait)]
        stops += [(lap * self.length + halt.place, halt.time) for lap in range(laps) for halt in self.halts]
        return Way(np.tile(curvature, laps), np.tile(limit, laps), lateral, stops=tuple(stops), step=step)


@dataclass(frozen=True)
class DrawnRound(Described):
    """A random circuit, with slopes, wind and pace, driven lap after lap."""

    time: Annotated[float, "s", POSITIVE] = 600.0

    @cached_property
    def circuit(self) -> Circuit:
        way = drawn(self.seed)
        conditions = (*way.conditions, *weather(self.seed, way.length))
        return replace(way, time=self.time, seed=self.seed, conditions=conditions)

    @property
    def duration(self) -> float:
        return self.time

    @property
    def start(self) -> Start:
        return self.circuit.start

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        return self._with_conditions(self.circuit.columns(time, distance, speed, ahead), time, distance)


def drawn(number: int) -> Circuit:
    """A random circuit: bends of 6.5 to 25 m radius, most of them to the left, and speed limits of 9 to 14 m/s.

    Some circuits have a wet patch, some two halts.

    Args:
        number: number of the circuit; the same number gives exactly the same circuit
    """
    # The second number separates this random stream from that of `weather`.
    chance = np.random.default_rng([number, 612])
    sections: list[Straight | Bend] = []
    for _ in range(12):
        sections.append(Straight(length=float(chance.uniform(9.0, 45.0))))
        radius = float(np.exp(chance.uniform(math.log(6.5), math.log(25.0))))
        turn = math.radians(chance.uniform(30.0, 110.0))
        sections.append(Bend(radius=radius, turn=turn if chance.random() < 0.65 else -turn))
    wet: tuple[AnyCondition, ...] = ()
    length = sum(section.length for section in sections)
    if chance.random() < 0.3:
        grip = float(chance.uniform(0.7, 0.9))
        wet = (Adhesion(window=Along(0.3 * length, 0.4 * length, 2.0, length), left=grip, right=grip),)
    halts: tuple[Halt, ...] = ()
    if chance.random() < 0.3:
        places, times = length * chance.uniform([0.2, 0.6], [0.4, 0.8]), chance.uniform(2.0, 8.0, 2)
        halts = tuple(Halt(float(place), float(time)) for place, time in zip(places, times, strict=True))
    return Circuit(
        name=f"round-{number}",
        sections=tuple(sections),
        halts=halts,
        transition=float(chance.uniform(4.5, 7.0)),
        speed=float(chance.uniform(9.0, 14.0)),
        lateral_acceleration=float(chance.uniform(3.5, 5.0)),
        conditions=wet,
        pace=Pace(acceleration=float(chance.uniform(1.5, 2.2)), braking=float(chance.uniform(2.0, 3.2))),
    )


def weather(seed: int, length: float) -> tuple[AnyCondition, ...]:
    """A slope on a part of a circuit, an uneven road, and a light wind.

    Args:
        length: length of the circuit [m]
    """
    chance = np.random.default_rng([seed, 613])
    start, extent = chance.uniform(0.1, 0.5) * length, chance.uniform(0.2, 0.4) * length
    bank, grade = np.radians(chance.uniform(-2.5, 2.5, 2))
    return (
        Slope(window=Along(start, start + extent, 20.0, length), bank=float(bank), grade=float(grade)),
        Unevenness(),
        Gusts(deviation=1.0),
    )
