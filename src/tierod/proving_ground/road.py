"""Roads: target speed and curvature of a drive through city, country and motorway, random but seeded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

GRID = 0.5
"""Spacing of a road's points [m]."""


@dataclass(frozen=True)
class Bends:
    """One kind of bend, drawn at random within ranges.

    Args:
        radius: smallest radius
        heading_change: over the whole bend
        share: how often this kind is drawn, against the other kinds of the same road
        returns: whether the bend is followed at once by its mirror image, as in a lane change
    """

    radius: Annotated[tuple[float, float], "m"]
    heading_change: Annotated[tuple[float, float], "rad"]
    share: float = 1.0
    returns: bool = False


@dataclass(frozen=True)
class RoadKind:
    """What a stretch of road is like.

    Args:
        name: "city", "country", "motorway", or another
        cruise_speed: speed where no bend slows the car down
        bends: kinds of bends
        gap: straight between two bends
        lateral_acceleration: comfort limit in bends, sets the speed there
        share: part of the drive's time
    """

    name: str
    cruise_speed: Annotated[tuple[float, float], "m/s"]
    bends: tuple[Bends, ...]
    gap: Annotated[tuple[float, float], "m"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    share: float


CITY = RoadKind(
    "city",
    (8.0, 14.0),
    (
        Bends((9.0, 18.0), (math.radians(60.0), math.radians(100.0)), 0.4),
        Bends((35.0, 150.0), (math.radians(15.0), math.radians(60.0)), 0.6),
    ),
    (20.0, 120.0),
    2.5,
    0.30,
)
COUNTRY = RoadKind(
    "country",
    (16.0, 27.0),
    (Bends((70.0, 450.0), (math.radians(15.0), math.radians(70.0))),),
    (20.0, 160.0),
    3.0,
    0.40,
)
MOTORWAY = RoadKind(
    "motorway",
    (28.0, 36.0),
    (
        Bends((600.0, 2000.0), (math.radians(5.0), math.radians(20.0)), 0.5),
        Bends((900.0, 1800.0), (math.radians(2.0), math.radians(4.0)), 0.5, returns=True),
    ),
    (80.0, 600.0),
    2.0,
    0.30,
)
MIXED = (CITY, COUNTRY, MOTORWAY)
"""City, country and motorway in the shares that open the paper's gate about 36 % of the time."""


@dataclass(frozen=True)
class Road:
    """A road driven at its target speed.

    Args:
        time: instants at which the points are passed [s], shape (n,)
        distance: along the road [m], shape (n,)
        curvature: positive to the left [1/m], shape (n,)
        speed: target speed [m/s], shape (n,)
        kinds: names of the stretches
        starts: instants at which the stretches begin [s]
    """

    time: np.ndarray
    distance: np.ndarray
    curvature: np.ndarray
    speed: np.ndarray
    kinds: tuple[str, ...]
    starts: tuple[float, ...]

    def curvature_at(self, time: np.ndarray) -> np.ndarray:
        """Curvature [1/m] where the car is at instants [s]."""
        return np.interp(time, self.time, self.curvature)

    def speed_at(self, time: np.ndarray) -> np.ndarray:
        """Target speed [m/s] at instants [s]."""
        return np.interp(time, self.time, self.speed)


def random_road(
    seconds: float,
    generator: np.random.Generator,
    kinds: tuple[RoadKind, ...] = MIXED,
    cycle: float = 780.0,
    acceleration: float = 1.5,
    braking: float = 2.0,
) -> Road:
    """A road for a drive of at least this duration.

    Args:
        seconds: duration [s]
        generator: source of chance
        kinds: stretches, repeated in this order
        cycle: time after which the stretches repeat, at the most [s]
        acceleration: limit after bends [m/s**2]
        braking: limit before bends [m/s**2]
    """
    curvatures: list[np.ndarray] = []
    limits: list[np.ndarray] = []
    stretches: list[tuple[str, int]] = []
    planned, points, heading = 0.0, 0, 0.0
    total_share = sum(kind.share for kind in kinds)
    while planned < 1.1 * seconds + 5.0:
        for kind in kinds:
            stretches.append((kind.name, points))
            end = planned + min(cycle, seconds) * kind.share / total_share
            while planned < end:
                curvature, limit, heading = _bend(kind, generator, heading)
                curvatures.append(curvature)
                limits.append(limit)
                points += len(curvature)
                planned += float(np.sum(GRID / limit))
    return _driven(np.concatenate(curvatures), np.concatenate(limits), stretches, acceleration, braking)


def _bend(kind: RoadKind, generator: np.random.Generator, heading: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Curvature and speed limit of a straight and a bend, and the heading after it."""
    shares = np.array([bends.share for bends in kind.bends])
    bends = kind.bends[generator.choice(len(kind.bends), p=shares / shares.sum())]
    radius = math.exp(generator.uniform(*np.log(bends.radius)))
    change = generator.uniform(*bends.heading_change)
    left = generator.random() < 0.5 - 0.25 * math.tanh(heading)
    shape = _rounded(change * radius, generator.uniform(0.5, 1.0)) / radius * (1.0 if left else -1.0)
    if bends.returns:
        shape = np.concatenate([shape, -shape])
    straight = np.zeros(int(generator.uniform(*kind.gap) / GRID))
    curvature = np.concatenate([straight, shape])
    cruise = generator.uniform(*kind.cruise_speed)
    limit = np.minimum(cruise, np.sqrt(kind.lateral_acceleration / np.maximum(np.abs(curvature), 1e-6)))
    return curvature, limit, heading + float(np.sum(shape)) * GRID


def _rounded(arc: float, ramps: float) -> np.ndarray:
    """A bump of height one whose ends rise and fall like a cosine; its area is the arc [m].

    Args:
        arc: length of the circular bend it replaces [m]
        ramps: share of the length taken by the two ends [-]
    """
    length = arc / (1.0 - 0.5 * ramps)
    place = (np.arange(max(int(length / GRID), 2)) + 0.5) * GRID / length
    rise = np.minimum(np.minimum(place, 1.0 - place) / (0.5 * ramps), 1.0)
    return 0.5 - 0.5 * np.cos(math.pi * np.clip(rise, 0.0, 1.0))


def _driven(
    curvature: np.ndarray, limit: np.ndarray, stretches: list[tuple[str, int]], acceleration: float, braking: float
) -> Road:
    """The road with the fastest speed that keeps limits, acceleration and braking; v^2 is linear over distance."""
    distance = np.arange(len(curvature)) * GRID
    squared = np.minimum.accumulate(limit**2 - 2.0 * acceleration * distance) + 2.0 * acceleration * distance
    reach = squared + 2.0 * braking * distance
    squared = np.minimum.accumulate(reach[::-1])[::-1] - 2.0 * braking * distance
    speed = np.sqrt(squared)
    time = np.concatenate([[0.0], np.cumsum(2.0 * GRID / (speed[1:] + speed[:-1]))])
    starts = tuple(float(time[min(point, len(time) - 1)]) for _, point in stretches)
    return Road(time, distance, curvature, speed, tuple(name for name, _ in stretches), starts)
