"""Whether the accelerations go with the motion: sensors that the filters take in, that can fail, and that none judges.

A filter that believes a wrong acceleration blames what makes forces, the motors and the drives. The motion tells what
an accelerometer should read without any force: the slope of the speed along, yaw rate times speed across. That holds on
ice as well; slopes and banks of the road, which it does not see, change slowly.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.monitors.condition.recording_checks.motion import BLOCK, Block, Motion
from tierod.monitors.condition.signals import ACCELERATIONS

MOTION = {"longitudinal_acceleration": "the slope of the wheel speeds", "lateral_acceleration": "yaw rate times speed"}
"""What tells each of them, in words."""
HALF = 0.7
"""Share of the blocks of a window that must tell something."""


@dataclass(frozen=True)
class Bounds:
    """How far a fault-free acceleration goes from what the motion tells of it.

    Fault-free rounds of three virtual demonstrators, ice with adhesion .15 to .3 included, show at most 1.4 m/s**2 in
    one block, 0.9 in the mean of 3 s, and 0.44 or 0.26 of the motion's own about its mean in 10 s.

    Args:
        single: in one block
        level: mean over `level_time`; a slope of 16 % looks the same
        level_time: over which it must last
        shape: standard deviation of the difference over `shape_time`, where the motion changes little
        share: the same, as a share of the standard deviation of what the motion tells
        shape_time: over which both are taken
        noise: standard deviation from sample to sample over `level_time`; sensors have .05, rough roads some tenths
        doubtful: share of these bounds beyond which an acceleration is a candidate beside what is declared
    """

    single: Annotated[float, "m/s**2"] = 3.5
    level: Annotated[float, "m/s**2"] = 1.6
    level_time: Annotated[float, "s"] = 3.0
    shape: Annotated[float, "m/s**2"] = 0.7
    share: Annotated[float, ""] = 0.35
    shape_time: Annotated[float, "s"] = 10.0
    noise: Annotated[float, "m/s**2"] = 1.0
    doubtful: Annotated[float, ""] = 0.7


class Disagreement(NamedTuple):
    """That an acceleration does not go with the motion.

    Args:
        element: its name
        sure: beyond the bounds; else beyond the doubtful share of them only
        window: start of the window that showed it [s]
        start: from when on it disagrees, to half a second [s]
        found: when that was known [s]
        size: standard deviation, or mean, of the difference there [m/s**2]
    """

    element: str
    sure: bool
    window: Annotated[float, "s"]
    start: Annotated[float, "s"]
    found: Annotated[float, "s"]
    size: Annotated[float, "m/s**2"]


class AccelerationCheck:
    """Follows both accelerations beside the motion, piece by piece, and what has disagreed.

    Args:
        vehicle: its parameters
        rate: of the samples [Hz]
        bounds: of fault-free accelerations
    """

    def __init__(self, vehicle: Any, rate: float, bounds: Bounds | None = None):
        self._motion, self._rate, self._bounds = Motion(vehicle, rate), rate, bounds or Bounds()
        most = round(self._bounds.shape_time / BLOCK)
        self._windows: dict[str, deque[tuple[float, float, float, float]]] = {
            name: deque(maxlen=most) for name in ACCELERATIONS
        }
        self._begin: float | None = None
        self.found: dict[str, Disagreement] = {}

    def add(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> dict[str, int]:
        """The next piece, and from which of its samples on each acceleration that fails in it is not to be used.

        Args:
            time: [s], (n,)
            signals: by name, (n,) each; NaN where missing
        """
        self._begin = float(time[0]) if self._begin is None else self._begin
        blocks, failed = self._motion.add(signals), {}
        for block in blocks:
            for place, name in enumerate(ACCELERATIONS):
                if self._follow(name, place, block):
                    end = self._begin + block.end / self._rate
                    failed[name] = int(np.searchsorted(time, end - 0.5 / self._rate))
        return failed

    def gone(self, name: str) -> bool:
        """Whether an acceleration has failed."""
        return name in self.found and self.found[name].sure

    def _follow(self, name: str, place: int, block: Block) -> bool:
        """Whether an acceleration fails with this block; one that has failed stays so."""
        if self.gone(name):
            return False
        assert self._begin is not None
        end, window = self._begin + block.end / self._rate, self._windows[name]
        window.append((end, block.read[place] - block.moved[place], block.moved[place], block.rough[place]))
        rows = np.array(window)
        sure = self._beyond(rows, 1.0)
        found = sure or self._beyond(rows, self._bounds.doubtful)
        if found is not None and (sure or name not in self.found):
            begin, size = found
            off = [row for row in rows if row[0] > begin and max(abs(row[1]), row[3]) >= size]
            start = off[0][0] - BLOCK if off else begin
            self.found[name] = Disagreement(name, sure is not None, begin, float(start), end, size)
        return sure is not None

    def _beyond(self, window: np.ndarray, share: float) -> tuple[float, float] | None:
        """Start of the window [s] and size [m/s**2] of a difference beyond a share of the bounds, if there is one."""
        bounds, there = self._bounds, np.isfinite(window[:, 1])
        if not there[-1]:
            return None
        last = window[-1]
        if abs(last[1]) > bounds.single:
            return float(last[0] - BLOCK), float(abs(last[1]))
        short = round(bounds.level_time / BLOCK)
        recent, told = window[-short:][there[-short:]], window[there]
        if len(recent) >= HALF * short:
            level, noise = abs(float(recent[:, 1].mean())), float(recent[:, 3].mean())
            if level > share * bounds.level:
                return float(recent[0, 0] - BLOCK), level
            if noise > share * bounds.noise:
                return float(recent[0, 0] - BLOCK), noise
        apart = float(np.std(told[:, 1]))
        if len(told) < HALF * bounds.shape_time / BLOCK:
            return None
        if apart > share * max(bounds.shape, bounds.share * float(np.std(told[:, 2]))):
            return float(told[0, 0] - BLOCK), apart
        return None
