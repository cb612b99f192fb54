"""Two ways to tell one quantity, block by block: whether they differ by more than fault-free ones do."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

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
        rows = np.array(self._rows)
        sure = self._beyond(rows, 1.0)
        hit = sure or self._beyond(rows, self._bounds.doubtful)
        if hit is not None and (sure or self.found is None):
            begin, size = hit
            much = [each.end for each in self._rows if each.end > begin and max(abs(each.apart), each.noise) >= size]
            start = much[0] - BLOCK if much else begin
            self.found = Difference(sure is not None, begin, start, row.end, size)
        return sure is not None

    def _beyond(self, rows: np.ndarray, share: float) -> tuple[float, float] | None:
        """Start of the window [s] and size of a difference beyond a share of the bounds, if there is one."""
        bounds, there = self._bounds, np.isfinite(rows[:, 1])
        if not there[-1]:
            return None
        if abs(rows[-1, 1]) > bounds.single:
            return float(rows[-1, 0] - BLOCK), float(abs(rows[-1, 1]))
        short = round(LEVEL_TIME / BLOCK)
        recent, told = rows[-short:][there[-short:]], rows[there]
        if len(recent) >= HALF * short:
            level, noise = abs(float(recent[:, 1].mean())), float(recent[:, 3].mean())
            if level > share * bounds.level:
                return float(recent[0, 0] - BLOCK), level
            if noise > share * bounds.noise:
                return float(recent[0, 0] - BLOCK), noise
        apart = float(np.std(told[:, 1]))
        enough = len(told) >= HALF * SHAPE_TIME / BLOCK
        if enough and apart > share * max(bounds.shape, bounds.share * float(np.std(told[:, 2]))):
            return float(told[0, 0] - BLOCK), apart
        return None
