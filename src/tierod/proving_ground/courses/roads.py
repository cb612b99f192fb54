"""Kinds of roads that chance makes a drive of: city, country, motorway."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.proving_ground.courses.way import bump

Pair = tuple[float, float]
"""Lowest and highest value of what chance draws."""


def _in_order(what: str, pair: Pair) -> None:
    if not pair[0] <= pair[1]:
        raise ParameterError(f"the {what} is {pair[0]:g} to {pair[1]:g}; give the lower value first")


@dataclass(frozen=True)
class Bends:
    """One kind of bend, drawn at random within ranges.

    Args:
        radius: smallest radius
        turn: change of heading over the whole bend
        share: how often this kind is drawn, against the other kinds of the same road
        returns: whether the bend is followed at once by its mirror image, as in a lane change
    """

    radius: Annotated[Pair, "m", POSITIVE]
    turn: Annotated[Pair, "rad", POSITIVE]
    share: Annotated[float, "", POSITIVE] = 1.0
    returns: bool = False

    def __post_init__(self):
        _in_order("radius of bends", self.radius)
        _in_order("turn of bends", self.turn)

    def draw(self, generator: np.random.Generator, heading: float) -> np.ndarray:
        """Curvature [1/m] of one bend; the more often to the right the further the heading [rad] is to the left."""
        radius = math.exp(generator.uniform(*np.log(self.radius)))
        turn = generator.uniform(*self.turn)
        left = generator.random() < 0.5 - 0.25 * math.tanh(heading)
        shape = bump(turn * radius, generator.uniform(0.5, 1.0)) / radius * (1.0 if left else -1.0)
        return np.concatenate([shape, -shape]) if self.returns else shape


@dataclass(frozen=True)
class Roundabouts:
    """Roundabouts of right-hand traffic: to the right, round the island to the left, and out to the right.

    Args:
        radius: of the way round the island
        entry_radius: of the way in and out
        deflection: to the right, on the way in and out
        share: how often one is drawn, against the bends of the same road
    """

    radius: Annotated[Pair, "m", POSITIVE] = (12.0, 20.0)
    entry_radius: Annotated[Pair, "m", POSITIVE] = (18.0, 30.0)
    deflection: Annotated[Pair, "rad", POSITIVE] = (math.radians(30.0), math.radians(45.0))
    share: Annotated[float, "", POSITIVE] = 1.0

    def __post_init__(self):
        _in_order("radius of roundabouts", self.radius)
        _in_order("entry radius of roundabouts", self.entry_radius)
        _in_order("deflection of roundabouts", self.deflection)

    def draw(self, generator: np.random.Generator, heading: float) -> np.ndarray:
        """Curvature [1/m] of one roundabout, left straight on or to the left."""
        radius, entry = generator.uniform(*self.radius), generator.uniform(*self.entry_radius)
        deflection = generator.uniform(*self.deflection)
        onwards = 0.5 * math.pi * (generator.random() < 0.4 - 0.2 * math.tanh(heading))
        inwards = -bump(entry * deflection, 0.7) / entry
        around = bump(radius * (2.0 * deflection + onwards), 0.5) / radius
        return np.concatenate([inwards, around, inwards])


@dataclass(frozen=True)
class RoadKind:
    """What a stretch of road is like.

    Args:
        speed: where no bend slows the car down, drawn anew for every bend
        bends: kinds of bends, and roundabouts
        gap: straight between two bends
        lateral_acceleration: comfort limit in bends
        share: part of the drive's time
        halts: part of the bends before which the car halts, at a light or a junction
        halt: how long
        crossfall: of the straight road, positive falls to the right
        superelevation: part of the lateral acceleration in a bend that the bank of the road takes
        greatest_bank: of the road
        grade: standard deviation
        hills: length from valley to hilltop
    """

    speed: Annotated[Pair, "m/s", POSITIVE]
    bends: tuple[Bends | Roundabouts, ...]
    gap: Annotated[Pair, "m", NOT_NEGATIVE]
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE]
    share: Annotated[float, "", POSITIVE]
    halts: Annotated[float, "", SHARE] = 0.0
    halt: Annotated[Pair, "s", POSITIVE] = (3.0, 20.0)
    crossfall: Annotated[float, "rad", ANY] = 0.02
    superelevation: Annotated[float, "", SHARE] = 0.15
    greatest_bank: Annotated[float, "rad", NOT_NEGATIVE] = 0.06
    grade: Annotated[float, "rad", NOT_NEGATIVE] = 0.015
    hills: Annotated[Pair, "m", POSITIVE] = (150.0, 400.0)

    def __post_init__(self):
        for name in ("speed", "gap", "halt", "hills"):
            _in_order(f"{name} of a road", getattr(self, name))
        if not self.bends:
            raise ParameterError("a road needs at least one kind of bends")

    def bend(self, generator: np.random.Generator, heading: float) -> np.ndarray:
        """Curvature [1/m] of the next bend."""
        shares = np.array([bends.share for bends in self.bends])
        kind = generator.choice(len(self.bends), p=shares / shares.sum())
        return self.bends[kind].draw(generator, heading)


@dataclass(frozen=True)
class City(RoadKind):
    """Streets with junctions, lights, roundabouts and lane changes."""

    speed: Annotated[Pair, "m/s", POSITIVE] = (8.0, 14.0)
    bends: tuple[Bends | Roundabouts, ...] = (
        Bends((9.0, 18.0), (math.radians(60.0), math.radians(100.0)), 0.35),
        Bends((35.0, 150.0), (math.radians(15.0), math.radians(60.0)), 0.5),
        Bends((60.0, 120.0), (math.radians(9.0), math.radians(12.0)), 0.1, returns=True),
        Roundabouts(share=0.05),
    )
    gap: Annotated[Pair, "m", NOT_NEGATIVE] = (20.0, 120.0)
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 2.5
    share: Annotated[float, "", POSITIVE] = 0.30
    halts: Annotated[float, "", SHARE] = 0.15


@dataclass(frozen=True)
class Country(RoadKind):
    """Winding roads through hills, with a few junctions and roundabouts."""

    speed: Annotated[Pair, "m/s", POSITIVE] = (16.0, 27.0)
    bends: tuple[Bends | Roundabouts, ...] = (
        Bends((70.0, 450.0), (math.radians(15.0), math.radians(70.0)), 0.97),
        Roundabouts((16.0, 25.0), (25.0, 50.0), share=0.03),
    )
    gap: Annotated[Pair, "m", NOT_NEGATIVE] = (20.0, 160.0)
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 3.0
    share: Annotated[float, "", POSITIVE] = 0.40
    halts: Annotated[float, "", SHARE] = 0.02
    grade: Annotated[float, "rad", NOT_NEGATIVE] = 0.03


@dataclass(frozen=True)
class Motorway(RoadKind):
    """Wide bends and lane changes at high speed."""

    speed: Annotated[Pair, "m/s", POSITIVE] = (28.0, 36.0)
    bends: tuple[Bends | Roundabouts, ...] = (
        Bends((600.0, 2000.0), (math.radians(5.0), math.radians(20.0)), 0.5),
        Bends((900.0, 1800.0), (math.radians(2.0), math.radians(4.0)), 0.5, returns=True),
    )
    gap: Annotated[Pair, "m", NOT_NEGATIVE] = (80.0, 600.0)
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 2.0
    share: Annotated[float, "", POSITIVE] = 0.30
    hills: Annotated[Pair, "m", POSITIVE] = (400.0, 1000.0)


AnyRoad = City | Country | Motorway
