"""Figures of a headline over the motions of a drive, each from one standstill to the next, without reversing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import runs
from tierod.methods.detectors.reversing import ReversingLimits
from tierod.monitors.sideslip.grip_limit import BAND

STANDING = ReversingLimits().standing


class Largest(NamedTuple):
    """Sideslip angle with the largest lower bound of its band, with what belongs to its sample.

    Args:
        lower: lower bound of the 95 % band of the magnitude; minus infinity without a sample
        value, deviation: sideslip angle and its standard deviation, with the spread of the parameters
        own: standard deviation by the estimator alone
        geometry: sideslip angle of the same turn if the rear tyres did not slip
        speed: vehicle speed
    """

    lower: Annotated[float, "rad"] = -math.inf
    value: Annotated[float, "rad"] = 0.0
    deviation: Annotated[float, "rad"] = 0.0
    own: Annotated[float, "rad"] = 0.0
    geometry: Annotated[float, "rad"] = 0.0
    speed: Annotated[float, "m/s"] = 0.0


class Announced(NamedTuple):
    """Announcements of the limit of grip.

    Args:
        first: time of the first sample [s]; infinite without one
        samples: number of samples
        used: largest share of the front axle's grip in use [-]
    """

    first: float = math.inf
    samples: int = 0
    used: float = 0.0


class Samples(NamedTuple):
    """Samples of the next piece, (n,) each.

    Args:
        time: [s]
        speed: [m/s]; NaN where missing
        reverses: whether the car is known to reverse
        judged: whether a sample may enter a headline
        value, deviation, own, geometry: see `Largest` [rad]
        ahead: whether the limit of grip is announced
        used: share of the front axle's grip in use [-]
    """

    time: np.ndarray
    speed: np.ndarray
    reverses: np.ndarray
    judged: np.ndarray
    value: np.ndarray
    deviation: np.ndarray
    own: np.ndarray
    geometry: np.ndarray
    ahead: np.ndarray
    used: np.ndarray


class Part(NamedTuple):
    """Samples of one motion within a piece.

    Args:
        samples: those that may count
        reversed: whether all samples of the motion before them belong to reversing
        ended: whether the motion ends with them
    """

    samples: slice
    reversed: bool
    ended: bool


def parts_of_motions(speed: np.ndarray, reverses: np.ndarray) -> Iterator[Part]:
    """The motions of the next piece; an empty part of none comes first where the motion before it has ended.

    Args:
        speed: [m/s]; NaN where missing, which ends no motion
        reverses: whether the car is known to reverse
    """
    moves = ~(np.abs(speed) < STANDING)
    if len(moves) and not moves[0]:
        yield Part(slice(0, 0), False, ended=True)
    for start, stop in zip(*runs(moves), strict=True):
        known = np.flatnonzero(reverses[start:stop])
        begin = start + int(known[-1]) + 1 if len(known) else start
        yield Part(slice(begin, stop), bool(len(known)), ended=stop < len(moves))


class FiguresOverMotions:
    """Largest sideslip angle and announcements of the limit of grip; a motion that turns out to reverse leaves none.

    A car with unsigned speeds shows only after some turning that it reverses: figures of a motion count once it has
    ended, or the drive has. The result does not depend on how the drive is cut.
    """

    def __init__(self) -> None:
        self._largest, self._announced = Largest(), Announced()
        self._moving = Largest(), Announced()

    @property
    def largest(self) -> Largest:
        """Sideslip angle with the largest lower bound."""
        return max(self._largest, self._moving[0])

    @property
    def announced(self) -> Announced:
        """Announcements of the limit of grip."""
        return _joined(self._announced, self._moving[1])

    def add(self, samples: Samples) -> None:
        """Add the next piece."""
        for part in parts_of_motions(samples.speed, samples.reverses):
            if part.reversed:
                self._moving = Largest(), Announced()
            self._move(Samples(*(each[part.samples] for each in samples)))
            if part.ended:
                self._largest, self._announced = self.largest, self.announced
                self._moving = Largest(), Announced()

    def _move(self, samples: Samples) -> None:
        """Add samples of one motion."""
        largest, announced = self._moving
        known = samples.judged & np.isfinite(samples.deviation)
        if known.any():
            lower = np.where(known, np.abs(samples.value) - BAND * samples.deviation, -math.inf)
            at = int(np.argmax(lower))
            names = (samples.value, samples.deviation, samples.own, samples.geometry, samples.speed)
            largest = max(largest, Largest(float(lower[at]), *(float(each[at]) for each in names)))
        ahead = samples.ahead & samples.judged
        first = float(samples.time[np.argmax(ahead)]) if ahead.any() else math.inf
        used = float(np.max(samples.used[samples.judged], initial=0.0))
        self._moving = largest, _joined(announced, Announced(first, int(ahead.sum()), used))


def _joined(one: Announced, other: Announced) -> Announced:
    return Announced(min(one.first, other.first), one.samples + other.samples, max(one.used, other.used))
