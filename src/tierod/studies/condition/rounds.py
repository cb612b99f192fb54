"""The rounds that the demonstrator drives: the three of the tests, and any number of others drawn at random."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from tierod.proving_ground.courses.catalogue import AnyCourse, load
from tierod.proving_ground.courses.circuit import Bend, Circuit, Halt, Straight
from tierod.proving_ground.courses.conditions import Adhesion, AnyCondition, Gusts, Slope, Unevenness
from tierod.proving_ground.courses.plan import Pace
from tierod.proving_ground.courses.window import Along

SHORT, LONG, THIRD = "short-round", "long-round", "third-round"
"""The rounds of the tests, redrawn in kind after Figures 18, 19 and 24 of Li, Frey, Gauterin."""


@lru_cache(maxsize=64)
def course(name: str, seconds: float, seed: int = 0) -> AnyCourse:
    """A round, or any shipped course, as it is driven.

    Args:
        name: of a shipped course, or "round-17" for one of those drawn at random
        seconds: how long a round is driven
        seed: of slopes, unevenness and wind; the way itself goes by the name alone
    """
    way = drawn(int(name.removeprefix("round-"))) if name.startswith("round-") else load(name)
    if not isinstance(way, Circuit):
        return way
    weather = _weather(np.random.default_rng([seed, 613]), way.length)
    return replace(way, time=seconds, seed=seed, conditions=(*way.conditions, *weather))


def drawn(number: int) -> Circuit:
    """A round drawn at random: bends of 6.5 to 25 m radius, more of them to the left, at up to 9 to 14 m/s.

    Some have a wet patch, some two halts.
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


def _weather(chance: np.random.Generator, length: float) -> tuple[AnyCondition, ...]:
    """A slope on a part of the round, an uneven road, and a light wind."""
    start, extent = chance.uniform(0.1, 0.5) * length, chance.uniform(0.2, 0.4) * length
    bank, grade = np.radians(chance.uniform(-2.5, 2.5, 2))
    return (
        Slope(window=Along(start, start + extent, 20.0, length), bank=float(bank), grade=float(grade)),
        Unevenness(),
        Gusts(deviation=1.0),
    )
