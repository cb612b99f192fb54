"""Axles of which both wheels spin or skid: no motion of the car explains their speed, and no single sensor does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.series import LastRead, runs
from tierod.monitors.condition.signals import ALL_WHEELS

AXLES = ("front", "rear")
SPUN, SKIDDED = "spun", "skidded"
_PLACES = [[place for place, name in enumerate(ALL_WHEELS) if axle in name] for axle in AXLES]
_ALL = "all"
_SHOWN = 3
"""Largest number of slips that a sentence names."""


@dataclass(frozen=True)
class AxleSlipLimits:
    """Limits from which both wheels of an axle slip.

    Tyres accelerate and brake a car by their friction alone. The speed of each axle therefore bounds that of the car at
    all later times; an axle of which both wheels are beyond these bounds slips. In a bend one front wheel is always
    slower than one rear wheel, so that neither yaw rate nor steering angle is needed.

    Args:
        acceleration: largest acceleration of a car along the road; 1.1 g is the most that tyres of road cars transmit
        share: slip from which it counts, as a share of the speed; the filters allow for less
        least: the same at small speed; wheel speed sensors end at 0.3 to 0.8 m/s
        agrees: share of these limits up to which the axles differ while neither slips
        recovers: time after a slip in which it still counts, since tyres slip less but far from usually
        alike, alike_least: difference of both wheels of an axle from both of the other one, as a share of the speed and
            beside it, from which no single wheel of it is wrong; front wheels on their wider way differ by 4 % in a
            bend of 10 m, and rough roads and coarse readings by some .1 m/s
        longest: longest slip; two wheel sensors that fail alike stay wrong for longer
        fresh: longest time for which a reading holds; chassis buses send every 10 to 100 ms
    """

    acceleration: Annotated[float, "m/s**2"] = 11.0
    share: Annotated[float, ""] = 0.25
    least: Annotated[float, "m/s"] = 0.8
    agrees: Annotated[float, ""] = 0.5
    recovers: Annotated[float, "s"] = 1.0
    alike: Annotated[float, ""] = 0.04
    alike_least: Annotated[float, "m/s"] = 0.3
    longest: Annotated[float, "s"] = 15.0
    fresh: Annotated[float, "s"] = 0.25


class Slip(NamedTuple):
    """Slip of both wheels of an axle, or of all wheels.

    Args:
        axle: "front", "rear", or "all"
        kind: `SPUN` or `SKIDDED`
        start, end: first and last sample of it [s]
    """

    axle: str
    kind: str
    start: float
    end: float


class AxleSlip:
    """Recognises piece by piece when both wheels of an axle spin or skid; the cut into pieces does not matter.

    Args:
        limits: limits of the decision
    """

    def __init__(self, limits: AxleSlipLimits | None = None):
        self._limits = limits or AxleSlipLimits()
        self._read = LastRead(len(ALL_WHEELS), self._limits.fresh)
        self._bounds = np.array([np.inf, -np.inf])
        self._time = self._agreed = 0.0
        self._begun, self._last = np.nan, -np.inf
        self._found: list[Slip] = []
        self.alike: dict[str, list[tuple[float, float]]] = {axle: [] for axle in AXLES}
        """Bounds of the times in which both wheels of each axle are faster, or slower, than the other axle [s]."""

    @property
    def found(self) -> tuple[Slip, ...]:
        """Slips in the order of time; those of one axle with hardly any time between them are one."""
        merged: list[Slip] = []
        for each in self._found:
            before = next((other for other in reversed(merged) if other[:2] == each[:2]), None)
            if before is not None and each.start - before.end < self._limits.recovers:
                merged[merged.index(before)] = before._replace(end=each.end)
            else:
                merged.append(each)
        return tuple(merged)

    def add(self, time: np.ndarray, wheels: np.ndarray) -> np.ndarray:
        """Add the next piece, and return whether an axle slips, or did shortly before, at each sample, (n,).

        Args:
            time: time stamps [s], (n,)
            wheels: speeds of the wheels in the order of `ALL_WHEELS` [m/s], (n, 4); NaN if missing
        """
        if not len(time):
            return np.zeros(0, bool)
        limits, speeds = self._limits, np.abs(self._read.held(time, wheels))
        slower, faster = (np.array([pick(speeds[:, each], axis=1) for each in _PLACES]) for pick in (np.min, np.max))
        self._compare(time, slower, faster)
        speed = self._speed(slower, faster)
        least, most = self._bounded(time, slower, faster, np.isfinite(speed))
        with np.errstate(invalid="ignore"):
            spins = slower > least * (1.0 + limits.share) + limits.least
            skids = most > faster * (1.0 + limits.share) + limits.least
        slips = np.zeros(len(time), bool)
        values = np.concatenate(([self._agreed], speed))
        agreed = values[np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))][1:]
        self._agreed = float(agreed[-1])
        there = np.asarray((spins | skids).any(axis=0))
        if not there[0]:
            self._begun = np.nan
        for start, stop in zip(*runs(there), strict=True):
            goes_on = start == 0 and np.isfinite(self._begun)
            self._begun = self._begun if goes_on else float(time[start])
            counts = time[start:stop] - self._begun <= limits.longest
            slips[start:stop] = counts
            if counts.any():
                end = float(time[start:stop][counts][-1])
                if goes_on:
                    self._found[-1] = self._found[-1]._replace(end=end)
                else:
                    mean = 0.5 * (slower + faster)[:, start] - agreed[start]
                    self._found.append(Slip(*_named(spins[:, start], skids[:, start], mean), self._begun, end))
            if stop < len(time):
                self._begun = np.nan
        last = np.maximum.accumulate(np.where(slips, time, self._last))
        self._last = float(last[-1])
        return np.asarray(time - last <= limits.recovers)

    def _compare(self, time: np.ndarray, slower: np.ndarray, faster: np.ndarray) -> None:
        """Add the times in which both wheels of an axle differ from the other axle in the same direction."""
        for place, times in enumerate(self.alike.values()):
            with np.errstate(invalid="ignore"):
                least = self._limits.alike * faster[1 - place] + self._limits.alike_least
                differs = (slower[place] > faster[1 - place] + least) | (faster[place] < slower[1 - place] - least)
            for start, stop in zip(*runs(differs), strict=True):
                begin, end = float(time[start]), float(time[stop - 1])
                if times and begin - times[-1][1] < self._limits.recovers:
                    begin = times.pop()[0]
                times.append((begin, end))

    def _speed(self, slower: np.ndarray, faster: np.ndarray) -> np.ndarray:
        """Speed of the car where both axles agree, or where only one is read, (n,); NaN elsewhere."""
        means = 0.5 * (slower + faster)
        there = np.isfinite(means)
        speed = np.where(there, means, 0.0).sum(axis=0) / np.where(there.any(axis=0), there.sum(axis=0), np.nan)
        with np.errstate(invalid="ignore"):
            differ = np.abs(means[0] - means[1]) > self._limits.agrees * (
                self._limits.share * speed + self._limits.least
            )
        return np.where(differ, np.nan, speed)

    def _bounded(
        self, time: np.ndarray, slower: np.ndarray, faster: np.ndarray, agree: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest speed of the car by any axle now, and by both before, (n,)."""
        gained = self._limits.acceleration * (time - self._time)
        lowest, highest = np.nan_to_num(faster, nan=np.inf).min(axis=0), np.nan_to_num(slower, nan=-np.inf).max(axis=0)
        past = (np.where(agree, lowest - gained, np.inf), np.where(agree, highest + gained, -np.inf))
        least = np.minimum(np.minimum.accumulate(past[0]), self._bounds[0]) + gained
        most = np.maximum(np.maximum.accumulate(past[1]), self._bounds[1]) - gained
        self._bounds, self._time = np.array([least[-1], most[-1]]), float(time[-1])
        return np.minimum(least, lowest), np.maximum(most, highest)


def _named(spins: np.ndarray, skids: np.ndarray, gained: np.ndarray) -> tuple[str, str]:
    """Axle and kind of a slip that begins, (2,) each; `gained` is the change since both axles agreed [m/s]."""
    if spins.any() and skids.any():
        # One axle bounds the other: the axle that has changed its speed by more is the one that slips.
        place = int(np.argmax(np.abs(gained)))
        return AXLES[place], SPUN if gained[place] > 0.0 else SKIDDED
    flags, kind = (spins, SPUN) if spins.any() else (skids, SKIDDED)
    return _ALL if flags.all() else AXLES[int(np.argmax(flags))], kind


def slips_in_words(found: Sequence[Slip]) -> str:
    """Sentence on the times in which both wheels of an axle spun or skidded; "" if they never did.

    Args:
        found: slips in the order of time
    """
    if not found:
        return ""
    named = ", ".join(
        f"{'all wheels' if each.axle == _ALL else f'wheels of the {each.axle} axle'} {each.kind} from {each.start:.1f} "
        f"to {each.end:.1f} s"
        for each in found[:_SHOWN]
    )
    return f"{named} and {len(found) - _SHOWN} more times" if len(found) > _SHOWN else named
