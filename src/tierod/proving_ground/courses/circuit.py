"""Closed circuits and other ways put together from straights and bends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import ANY, NOT_NEGATIVE, POSITIVE
from tierod.proving_ground.courses.base import WayCourse
from tierod.proving_ground.courses.way import STEP, Way


@dataclass(frozen=True)
class Straight:
    """A straight section.

    Args:
        length: of its axis
        speed: limit on it
    """

    length: Annotated[float, "m", POSITIVE]
    speed: Annotated[float, "m/s", POSITIVE] = math.inf

    @property
    def curvature(self) -> float:
        """None [1/m]."""
        return 0.0


@dataclass(frozen=True)
class Bend:
    """A circular section.

    Args:
        radius: of its axis
        turn: change of heading, positive to the left
        speed: limit on it
    """

    radius: Annotated[float, "m", POSITIVE]
    turn: Annotated[float, "rad", ANY]
    speed: Annotated[float, "m/s", POSITIVE] = math.inf

    @property
    def length(self) -> float:
        """Of its axis [m]."""
        return self.radius * abs(self.turn)

    @property
    def curvature(self) -> float:
        """Positive to the left [1/m]."""
        return math.copysign(1.0 / self.radius, self.turn)


@dataclass(frozen=True)
class Halt:
    """A stop on the way.

    Args:
        place: from the beginning of the lap
        time: at rest
    """

    place: Annotated[float, "m", POSITIVE]
    time: Annotated[float, "s", NOT_NEGATIVE] = 3.0


@dataclass(frozen=True)
class Circuit(WayCourse):
    """A closed circuit, driven round and round; the joints of its sections are clothoids.

    Args:
        sections: in order
        transition: length over which the curvature passes from one section to the next
        time: how long it is driven
        speed: limit where no section sets a lower one
        lateral_acceleration: limit in bends
        wait: at rest before the start
        halts: stops of every lap, in order
    """

    sections: tuple[Straight | Bend, ...] = ()
    transition: Annotated[float, "m", POSITIVE] = 4.0
    time: Annotated[float, "s", POSITIVE] = 200.0
    speed: Annotated[float, "m/s", POSITIVE] = 10.0
    lateral_acceleration: Annotated[float, "m/s**2", POSITIVE] = 4.0
    wait: Annotated[float, "s", NOT_NEGATIVE] = 2.0
    halts: tuple[Halt, ...] = ()

    def __post_init__(self):
        if not self.sections:
            raise ParameterError("a circuit needs sections; give straights and bends")
        places = [0.0, *(halt.place for halt in self.halts), self.length]
        if not all(before < after for before, after in pairwise(places)):
            raise ParameterError(
                f"halts lie within the {self.length:g} m of a circuit, one after the other, not at {places[1:-1]} m"
            )

    @property
    def duration(self) -> float:
        """As long as it is driven [s]."""
        return self.time

    @cached_property
    def length(self) -> float:
        """Of one lap [m]."""
        return sum(section.length for section in self.sections)

    @cached_property
    def lap(self) -> tuple[np.ndarray, np.ndarray]:
        """Curvature [1/m] and limit of the speed [m/s] of one lap, on equal steps that fit into it."""
        count = math.ceil(self.length / STEP)
        place = np.arange(count) * self.length / count
        ends = np.cumsum([section.length for section in self.sections])
        turned = np.cumsum([section.length * section.curvature for section in self.sections])
        corners, headings = np.concatenate([[0.0], ends]), np.concatenate([[0.0], turned])
        return self._smoothed(place, corners, headings), self._limits(place, ends)

    def _smoothed(self, place: np.ndarray, corners: np.ndarray, headings: np.ndarray) -> np.ndarray:
        """Mean curvature over the transition's length, whose integral is exactly that of the sections."""

        def heading(where: np.ndarray) -> np.ndarray:
            laps = np.floor(where / self.length)
            return laps * headings[-1] + np.interp(where - laps * self.length, corners, headings)

        half = 0.5 * self.transition
        return (heading(place + half) - heading(place - half)) / self.transition

    def _limits(self, place: np.ndarray, ends: np.ndarray) -> np.ndarray:
        section = np.minimum(np.searchsorted(ends, place, side="right"), len(ends) - 1)
        return np.minimum(np.array([each.speed for each in self.sections])[section], self.speed)

    @cached_property
    def way(self) -> Way:
        """As many laps as the time may need."""
        curvature, limit = self.lap
        step = self.length / len(curvature)
        laps = math.ceil(self.time * float(np.max(limit)) / self.length) + 1
        lateral = np.full(laps * len(curvature), self.lateral_acceleration)
        stops = [(0.0, self.wait)]
        stops += [(lap * self.length + halt.place, halt.time) for lap in range(laps) for halt in self.halts]
        return Way(np.tile(curvature, laps), np.tile(limit, laps), lateral, stops=tuple(stops), step=step)
