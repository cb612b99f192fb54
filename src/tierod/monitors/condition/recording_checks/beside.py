"""Two ways to tell one quantity, block by block: whether they differ by more than fault-free ones do."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Annotated, NamedTuple

from tierod.monitors.condition.recording_checks.blocks import BLOCK

LEVEL_TIME, SHAPE_TIME = 3.0, 10.0
"""Over which the mean of a difference is taken, and its standard deviation [s]."""
HALF = 0.7
"""Share of the blocks of a window that must tell something."""


@dataclass(frozen=True)
class Bounds:
    """How far two ways to tell a quantity differ without a fault, in the unit of the quantity.

    Args:
        single: in one block
        level: mean over `LEVEL_TIME`
        shape: standard deviation over `SHAPE_TIME`, where the quantity changes little
        share: the same, as a share of the standard deviation of the quantity
        noise: of the reading from sample to sample, over `LEVEL_TIME`
        doubtful: share of these bounds beyond which a difference is worth a doubt
    """

    single: float
    level: float
    shape: float
    share: Annotated[float, ""]
    noise: float
    doubtful: Annotated[float, ""] = 0.7


def _deviation(values: Sequence[float]) -> float:
    """Standard deviation of a few values: an array would cost more than it saves."""
    mean = sum(values) / len(values)
    return sqrt(sum((each - mean) ** 2 for each in values) / len(values))


class Row(NamedTuple):
    """One block: its end [s], difference, quantity that it is compared with, noise of the reading."""

    end: float
    apart: float
    told: float
    noise: float


class Difference(NamedTuple):
    """A difference beyond bounds.

    Args:
        sure: beyond all of a bound; else beyond the doubtful share of one only
        window: start of the window that showed it [s]
        start: from when on there is that much, to half a second [s]
        found: when that was known [s]
        size: mean, standard deviation or noise
    """

    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    size: float


class _Measure(NamedTuple):
    """Size of a difference over a window from `begin` [s] on, and its bound."""

    begin: float
    size: float
    bound: float


class Beside:
    """Follows a difference over its windows; the first sure one, or else the first doubtful one, stays.

    Args:
        bounds: of fault-free differences
    """

    def __init__(self, bounds: Bounds):
        self._bounds = bounds
        self._rows: deque[Row] = deque(maxlen=round(SHAPE_TIME / BLOCK))
        self.found: Difference | None = None

    @property
    def sure(self) -> bool:
        """Whether a difference beyond all of a bound was found."""
        return self.found is not None and self.found.sure

    def add(self, row: Row) -> bool:
        """The next block; whether it makes the difference sure."""
        if self.sure:
            return False
        self._rows.append(row)
        if not isfinite(row.apart):
            return False
        measures = self._measures()
        sure = next((each for each in measures if each.size > each.bound), None)
        doubtful = self._bounds.doubtful
        hit = sure or next((each for each in measures[1:] if each.size > doubtful * each.bound), None)
        if hit is not None and (sure or self.found is None):
            begin, size = hit.begin, hit.size
            much = [each.end for each in self._rows if each.end > begin and max(abs(each.apart), each.noise) >= size]
            start = much[0] - BLOCK if much else begin
            self.found = Difference(sure is not None, begin, start, row.end, size)
        return sure is not None

    def _measures(self) -> list[_Measure]:
        """What the windows show now: the last block, which says nothing of a doubt, the mean, the noise, the shape."""
        bounds, last = self._bounds, self._rows[-1]
        found = [_Measure(last.end - BLOCK, abs(last.apart), bounds.single)]
        short = round(LEVEL_TIME / BLOCK)
        told = [each for each in self._rows if isfinite(each.apart)]
        recent = [each for each in told if each.end > last.end - LEVEL_TIME - 0.5 * BLOCK][-short:]
        if len(recent) >= HALF * short:
            begin, count = recent[0].end - BLOCK, len(recent)
            found.append(_Measure(begin, abs(sum(each.apart for each in recent)) / count, bounds.level))
            found.append(_Measure(begin, sum(each.noise for each in recent) / count, bounds.noise))
        if len(told) >= HALF * SHAPE_TIME / BLOCK:
            bound = max(bounds.shape, bounds.share * _deviation([each.told for each in told]))
            found.append(_Measure(told[0].end - BLOCK, _deviation([each.apart for each in told]), bound))
        return found
