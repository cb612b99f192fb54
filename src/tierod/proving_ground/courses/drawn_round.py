"""Rounds that chance draws: as many different ones as there are seeds, for healthy driving that nobody has chosen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np

from tierod.core.fields import POSITIVE
from tierod.proving_ground.courses.base import Described
from tierod.proving_ground.courses.circuit import Bend, Circuit, Halt, Straight
from tierod.proving_ground.courses.conditions import Adhesion, AnyCondition, Gusts, Slope, Unevenness
from tierod.proving_ground.courses.course import Columns, Start
from tierod.proving_ground.courses.plan import Pace
from tierod.proving_ground.courses.window import Along


@dataclass(frozen=True)
class DrawnRound(Described):
    """A round that the seed draws, with its slopes, its wind and its pace, driven lap after lap.

    Args:
        time: how long it is driven
    """

    time: Annotated[float, "s", POSITIVE] = 600.0

    @cached_property
    def circuit(self) -> Circuit:
        """The round that the seed gives."""
        way = drawn(self.seed)
        conditions = (*way.conditions, *weather(self.seed, way.length))
        return replace(way, time=self.time, seed=self.seed, conditions=conditions)

    @property
    def duration(self) -> float:
        """As long as it is driven [s]."""
        return self.time

    @property
    def start(self) -> Start:
        """At rest."""
        return self.circuit.start

    def columns(self, time: np.ndarray, distance: np.ndarray, speed: np.ndarray | float, ahead: float) -> Columns:
        """Inputs at some instants, see `Course.columns`."""
        return self._with_conditions(self.circuit.columns(time, distance, speed, ahead), time, distance)


def drawn(number: int) -> Circuit:
    """A round drawn at random: bends of 6.5 to 25 m radius, more of them to the left, at up to 9 to 14 m/s.

    Some have a wet patch, some two halts.

    Args:
        number: of the round; the same number gives the same round to the bit
    """
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
    """A slope on a part of a round, an uneven road, and a light wind.

    Args:
        seed: of all of it
        length: of the round [m]
    """
    chance = np.random.default_rng([seed, 613])
    start, extent = chance.uniform(0.1, 0.5) * length, chance.uniform(0.2, 0.4) * length
    bank, grade = np.radians(chance.uniform(-2.5, 2.5, 2))
    return (
        Slope(window=Along(start, start + extent, 20.0, length), bank=float(bank), grade=float(grade)),
        Unevenness(),
        Gusts(deviation=1.0),
    )
