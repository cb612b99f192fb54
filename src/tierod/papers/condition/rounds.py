"""The rounds that the demonstrator drives: the three of the tests, and any number of others drawn at random."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from tierod.proving_ground.courses.catalogue import AnyCourse, load
from tierod.proving_ground.courses.circuit import Circuit
from tierod.proving_ground.courses.drawn_round import drawn, weather

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
    return replace(way, time=seconds, seed=seed, conditions=(*way.conditions, *weather(seed, way.length)))
