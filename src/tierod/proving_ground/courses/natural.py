"""Natural drives: city, country and motorway, random but seeded."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import cycle
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.gravity import GRAVITY
from tierod.proving_ground.courses.base import WAY, WayCourse
from tierod.proving_ground.courses.chance import smooth_noise
from tierod.proving_ground.courses.course import Columns
from tierod.proving_ground.courses.plan import reachable
from tierod.proving_ground.courses.roads import AnyRoad, City, Country, Motorway, RoadKind
from tierod.proving_ground.courses.way import STEP, Way

_BENDS, _HALTS, _HILLS = range(3)
_MARGIN = 5.0


@dataclass(frozen=True)
class NaturalDrive(WayCourse):
    """A drive over roads that chance makes, stretch by stretch; the same seed makes the same roads to the bit.

    Bends, halts and hills draw from streams of their own, so that more halts do not move a bend; they take their time
    from the drive, which then has fewer bends.

    Args:
        roads: kinds of roads, in order, again and again
        time: of the drive
        cycle: time after which the kinds come again, at the most
        wait: at rest before the start; 0 begins rolling
    """

    roads: tuple[AnyRoad, ...] = field(default_factory=lambda: (City(), Country(), Motorway()))
    time: Annotated[float, "s", POSITIVE] = 780.0
    cycle: Annotated[float, "s", POSITIVE] = 780.0
    wait: Annotated[float, "s", NOT_NEGATIVE] = 0.0

    def __post_init__(self):
        if not self.roads:
            raise ParameterError("a drive needs at least one kind of road; give city, country or motorway")

    @property
    def duration(self) -> float:
        """Of the drive [s]."""
        return self.time

    @cached_property
    def stretches(self) -> tuple[tuple[float, RoadKind], ...]:
        """(where it begins [m], kind) of every stretch."""
        return self._built[1]

    @cached_property
    def way(self) -> Way:
        """A road that takes at least the time of the drive."""
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
                piece, before = self._piece(kind, bends, heading)
                if halts.random() < kind.halts:
                    stops.append(((points + before) * STEP, halts.uniform(*kind.halt)))
                    planned += stops[-1][1]
                pieces.append(piece)
                points += len(piece[0])
                curved = np.sqrt(kind.lateral_acceleration / np.maximum(np.abs(piece[0]), 1e-6))
                planned += float(np.sum(STEP / np.minimum(piece[1], curved)))
                heading += float(np.sum(piece[0])) * STEP
        curvature, speed, lateral = (np.concatenate(part) for part in zip(*pieces, strict=True))
        slopes = self._slopes(curvature, speed, lateral, stretches)
        return Way(curvature, speed, lateral, slopes, tuple(stops)), tuple(stretches)

    def _piece(
        self, kind: RoadKind, generator: np.random.Generator, heading: float
    ) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], int]:
        """Curvature and limits of a straight and a bend, and the number of points of the straight."""
        shape = kind.bend(generator, heading)
        straight = np.zeros(int(generator.uniform(*kind.gap) / STEP))
        curvature = np.concatenate([straight, shape])
        limit = np.full(len(curvature), generator.uniform(*kind.speed))
        return (curvature, limit, np.full(len(curvature), kind.lateral_acceleration)), len(straight)

    def _slopes(
        self, curvature: np.ndarray, speed: np.ndarray, lateral: np.ndarray, stretches: list[tuple[float, RoadKind]]
    ) -> Columns:
        """Crossfall, superelevation and hills."""
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
    """Without kinks where stretches meet: mean over a length [m]."""
    count = round(length / STEP) | 1
    longer = np.pad(slope, count // 2, mode="edge")
    return np.convolve(longer, np.full(count, 1.0 / count), mode="valid")
