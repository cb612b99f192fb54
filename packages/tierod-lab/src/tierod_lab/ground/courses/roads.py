"""Closed circuits of straights and bends, and natural drives through city, country and motorway, both seeded."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import cycle, pairwise
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.physics.motion import GRAVITY
from tierod_lab.ground.courses.course import (
    Adhesion,
    Along,
    AnyCondition,
    Columns,
    Gusts,
    Slope,
    Start,
    Unevenness,
    smooth_noise,
)
from tierod_lab.ground.courses.way import STEP, WAY, Described, Pace, Way, WayCourse, bump, reachable


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

        def heading(where: np.ndarray) -> np.ndarray:
            laps = np.floor(where / self.length)
            return np.asarray(laps * headings[-1] + np.interp(where - laps * self.length, corners, headings))

        half = 0.5 * self.transition
        section = np.minimum(np.searchsorted(ends, place, side="right"), len(ends) - 1)
        limit = np.minimum(np.array([each.speed for each in self.sections])[section], self.speed)
        return np.asarray((heading(place + half) - heading(place - half)) / self.transition), np.asarray(limit)

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
    """The random circuit of a number: bends of 6.5 to 25 m radius, most of them to the left, limits of 9 to 14 m/s.

    Some circuits have a wet patch, some two halts.
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
    """A slope on a part of a circuit of a length [m], an uneven road, and a light wind."""
    chance = np.random.default_rng([seed, 613])
    start, extent = chance.uniform(0.1, 0.5) * length, chance.uniform(0.2, 0.4) * length
    bank, grade = np.radians(chance.uniform(-2.5, 2.5, 2))
    return (
        Slope(window=Along(start, start + extent, 20.0, length), bank=float(bank), grade=float(grade)),
        Unevenness(),
        Gusts(deviation=1.0),
    )


Pair = tuple[float, float]  # Range of a random value: lower and upper limit


def _in_order(part: object, of: str, *names: str) -> None:
    for name in names:
        low, high = getattr(part, name)
        if not low <= high:
            what = f"{name.replace('_', ' ')} of {of}"
            raise ParameterError(f"the {what} is {low:g} to {high:g}; give the lower value first")


@dataclass(frozen=True)
class Bends:
    """One kind of bend, drawn at random within ranges."""

    radius: Annotated[Pair, "m", POSITIVE]
    turn: Annotated[Pair, "rad", POSITIVE]
    share: Annotated[float, "", POSITIVE] = 1.0
    returns: bool = False

    def __post_init__(self) -> None:
        _in_order(self, "bends", "radius", "turn")

    def draw(self, generator: np.random.Generator, heading: float) -> np.ndarray:
        """Curvature of one bend [1/m]; the further left the heading [rad], the more likely a bend to the right."""
        radius = math.exp(generator.uniform(*np.log(self.radius)))
        turn = generator.uniform(*self.turn)
        left = generator.random() < 0.5 - 0.25 * math.tanh(heading)
        shape = bump(turn * radius, generator.uniform(0.5, 1.0)) / radius * (1.0 if left else -1.0)
        return np.concatenate([shape, -shape]) if self.returns else shape


@dataclass(frozen=True)
class Roundabouts:
    """Roundabouts of right-hand traffic: to the right, around the island to the left, and out to the right."""

    radius: Annotated[Pair, "m", POSITIVE] = (12.0, 20.0)
    entry_radius: Annotated[Pair, "m", POSITIVE] = (18.0, 30.0)
    deflection: Annotated[Pair, "rad", POSITIVE] = (math.radians(30.0), math.radians(45.0))
    share: Annotated[float, "", POSITIVE] = 1.0

    def __post_init__(self) -> None:
        _in_order(self, "roundabouts", "radius", "entry_radius", "deflection")

    def draw(self, generator: np.random.Generator, heading: float) -> np.ndarray:
        """Curvature of one roundabout with exit straight on or to the left [1/m]."""
        radius, entry = generator.uniform(*self.radius), generator.uniform(*self.entry_radius)
        deflection = generator.uniform(*self.deflection)
        onwards = 0.5 * math.pi * (generator.random() < 0.4 - 0.2 * math.tanh(heading))
        inwards = -bump(entry * deflection, 0.7) / entry
        around = bump(radius * (2.0 * deflection + onwards), 0.5) / radius
        return np.concatenate([inwards, around, inwards])


@dataclass(frozen=True)
class RoadKind:
    """Properties of one kind of road."""

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

    def __post_init__(self) -> None:
        _in_order(self, "a road", "speed", "gap", "halt", "hills")
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

_BENDS, _HALTS, _HILLS = range(3)
_MARGIN = 5.0  # Time by which the planned road exceeds the drive [s]


@dataclass(frozen=True)
class NaturalDrive(WayCourse):
    """A drive over random roads, stretch by stretch; the same seed gives exactly the same roads.

    Bends, halts and hills use separate random streams, so that more halts do not change the bends. Halts take their
    time from the drive, which then has fewer bends.
    """

    roads: tuple[AnyRoad, ...] = field(default_factory=lambda: (City(), Country(), Motorway()))
    time: Annotated[float, "s", POSITIVE] = 780.0
    cycle: Annotated[float, "s", POSITIVE] = 780.0
    wait: Annotated[float, "s", NOT_NEGATIVE] = 0.0  # time at rest before the start; 0 starts rolling

    def __post_init__(self) -> None:
        if not self.roads:
            raise ParameterError("a drive needs at least one kind of road; give city, country or motorway")

    @property
    def duration(self) -> float:
        return self.time

    @property
    def stretches(self) -> tuple[tuple[float, RoadKind], ...]:
        return self._built[1]

    @cached_property
    def way(self) -> Way:
        return self._built[0]

    @cached_property
    def _built(self) -> tuple[Way, tuple[tuple[float, RoadKind], ...]]:
        bends, halts = self.generator(WAY, _BENDS), self.generator(WAY, _HALTS)
        pieces: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        stops = [(0.0, self.wait)] if self.wait > 0.0 else []
        stretches: list[tuple[float, RoadKind]] = []
        planned, points, heading, whole = 0.0, 0, 0.0, sum(kind.share for kind in self.roads)
        for kind in cycle(self.roads):
            if planned > self.time + _MARGIN:
                break
            stretches.append((points * STEP, kind))
            end = planned + min(self.cycle, self.time) * kind.share / whole
            while planned < end:
                bend = kind.bend(bends, heading)
                straight = np.zeros(int(bends.uniform(*kind.gap) / STEP))
                piece = np.concatenate([straight, bend])
                limit = np.full(len(piece), bends.uniform(*kind.speed))
                if halts.random() < kind.halts:
                    stops.append(((points + len(straight)) * STEP, halts.uniform(*kind.halt)))
                    planned += stops[-1][1]
                pieces.append((piece, limit, np.full(len(piece), kind.lateral_acceleration)))
                points += len(piece)
                curved = np.sqrt(kind.lateral_acceleration / np.maximum(np.abs(piece), 1e-6))
                planned += float(np.sum(STEP / np.minimum(limit, curved)))
                heading += float(np.sum(piece)) * STEP
        curvature, speed, lateral = (np.concatenate(part) for part in zip(*pieces, strict=True))
        slopes = self._slopes(curvature, speed, lateral, stretches)
        return Way(curvature, speed, lateral, slopes, tuple(stops)), tuple(stretches)

    def _slopes(
        self, curvature: np.ndarray, speed: np.ndarray, lateral: np.ndarray, stretches: list[tuple[float, RoadKind]]
    ) -> Columns:
        generator = self.generator(WAY, _HILLS)
        limit = np.minimum(speed, np.sqrt(lateral / np.maximum(np.abs(curvature), 1e-6)))
        pulled = reachable(limit, STEP, self.pace.acceleration, self.pace.braking) ** 2 * curvature / GRAVITY
        bank, grade = np.empty(len(curvature)), np.empty(len(curvature))
        starts = [round(place / STEP) for place, _ in stretches]
        for (_, kind), first, last in zip(stretches, starts, [*starts[1:], len(curvature)], strict=True):
            tilted = kind.crossfall - kind.superelevation * pulled[first:last]
            bank[first:last] = np.clip(tilted, -kind.greatest_bank, kind.greatest_bank)
            hills = smooth_noise(generator, *kind.hills, STEP, int((last - first) * STEP / kind.hills[0]) + 2)
            grade[first:last] = kind.grade * hills[: last - first]
        return {"road.bank_angle": _softened(bank), "road.grade_angle": _softened(grade)}


def _softened(slope: np.ndarray, length: float = 20.0) -> np.ndarray:
    """Moving average over a length [m], which removes kinks between stretches."""
    # An odd number of points keeps the average centred.
    count = round(length / STEP) | 1
    longer = np.pad(slope, count // 2, mode="edge")
    return np.convolve(longer, np.full(count, 1.0 / count), mode="valid")
