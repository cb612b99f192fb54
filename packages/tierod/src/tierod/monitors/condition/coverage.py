"""Coverage of a recording: possible values, enough sensors, losses of signals, and readings that stay the same."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.core.signals import SIGNALS
from tierod.io.quality import impossible
from tierod.monitors.condition.signals import ALL_WHEELS, PLACES, SENSORS, TARGETS, ConditionSample
from tierod.monitors.condition.wiring import Problem
from tierod.monitors.stuck import Stuck

LEAST = 1.0  # time of driving, beyond a tolerated gap, for which a signal must be missing to count as lost [s]


class Loss(NamedTuple):
    """Loss of a sensor, an actuator's target, or a signal that the whole judgement needs, over part of the drive."""

    status: Status  # status of the affected element
    cause: str  # cause in words
    # start of the loss; None if the signal came and went, and was missing for most of the drive
    since: Annotated[float, "s"] | None
    until: Annotated[float, "s"] | None = None  # end of the loss; None if it lasted until the end of the drive


@dataclass
class Absence:
    """Follows the presence of a signal piece by piece; while the vehicle is parked it does not count as missing."""

    period: float  # sampling interval [s]
    borne: float  # longest tolerated gap, by which presence is reported too long [s]
    there: int = 0  # there, lacked: number of samples of driving with and without the signal
    lacked: int = 0
    lately: int = 0  # number of samples of driving without it since it was last present
    last: float = math.nan  # time at which it was last present [s]; NaN if it never was
    alone: int = 0  # number of samples of driving without it alone, since it was last present
    # bounds of the times without it alone, after which it came back [s]
    gaps: list[tuple[float, float]] = field(default_factory=list)

    def add(self, time: np.ndarray, there: np.ndarray, parked: np.ndarray, others: np.ndarray | None = None) -> None:
        lacks = ~there & ~parked
        if others is not None:
            self._follow(time, there, lacks & others)
        self.there += int(np.count_nonzero(there & ~parked))
        self.lacked += int(np.count_nonzero(lacks))
        places = np.flatnonzero(there)
        if len(places):
            self.last, self.lately = float(time[places[-1]]), 0
            lacks = lacks[places[-1] + 1 :]
        self.lately += int(np.count_nonzero(lacks))

    def _follow(self, time: np.ndarray, there: np.ndarray, lacks: np.ndarray) -> None:
        """Close the gaps of the next piece; before its first presence the signal has not begun, which is no gap."""
        places = np.flatnonzero(there)
        lacked = self.alone + np.concatenate([[0], np.cumsum(lacks)])
        before = np.concatenate([[self.last], time[places]])[:-1]
        long = np.diff(np.concatenate([[0], lacked[places]])) * self.period > LEAST
        for start, end in zip(before[long].tolist(), time[places][long].tolist(), strict=True):
            if not math.isnan(start):
                self.gaps.append((max(start - self.borne + self.period, 0.0), end))
        self.alone = int(lacked[-1] - (lacked[places[-1]] if len(places) else 0))

    @property
    def came(self) -> bool:
        return not math.isnan(self.last)

    @property
    def since(self) -> float | None:
        """Time from which the signal is missing until the end [s]; None if it was present at the end, or never."""
        lost = self.came and self.lately * self.period > LEAST
        return max(self.last - self.borne + self.period, 0.0) if lost else None

    def loss(self, status: Status, gone: str, rare: str) -> Loss | None:
        """Loss until the end, or for more than half of the drive, in words; None if there is none."""
        if self.since is not None:
            return Loss(status, f"{gone} since {self.since:.2f} s", self.since)
        if self.came and self.lacked > self.there and self.lacked * self.period > LEAST:
            whole = (self.there + self.lacked) * self.period
            return Loss(status, f"{rare} for only {self.there * self.period:.0f} of {whole:.0f} s of driving", None)
        if self.gaps:
            (start, end), *further = self.gaps
            more = f", and {len(further)} more time{'s' * (len(further) > 1)}" if further else ""
            return Loss(Status.NOT_TESTABLE, f"{gone} from {start:.2f} s to {end:.2f} s{more}", start, end)
        return None


LONG = 5.0  # time of driving for which a reading must stay the same [s]; coarse sensors on straight roads reach 3 s
SHORT = 1.0
"""The same where the steering angle shows that the reading should have changed, or where the reading hardly ever
repeats itself [s]: sensors come every 0.1 s or less and repeat a value a few times."""
TURNED = 0.05
"""Change of the yaw rate by the steering angle in that time that is no straight road [rad/s]: three steps of a sensor
of 1 degree per second."""
UNUSUAL, UNHEARD = 4.0, 50.0
"""Ratio of that time to the next longest one of the same sensor [-]: a coarse sensor repeats itself often. The second
is that of a reading with noise, which never stays the same."""


class Same(NamedTuple):
    """Time in which the reading stayed the same."""

    samples: int = 0  # number of samples of driving
    start: Annotated[float, "s"] = math.nan  # start, end: bounds of the time [s]
    end: Annotated[float, "s"] = math.nan
    least: float = math.inf  # least, most: range of the value by other sensors in it [unit of the reading]
    most: float = -math.inf


class Constancy:
    """Follows piece by piece for how long the reading stays exactly the same; standstill and gaps do not count.

    A sensor that fails to a plausible value, such as a yaw rate of zero on a straight road, contradicts no other.
    """

    def __init__(self, period: float, noisy: bool = False):
        self._period, self._last, self._noisy = period, math.nan, noisy
        self._now = Same()
        self._longest: list[Same] = []

    def add(self, time: np.ndarray, readings: np.ndarray, moving: np.ndarray, others: np.ndarray) -> None:
        counts = np.flatnonzero(np.isfinite(readings) & moving)
        if not len(counts):
            return
        time, values, others = time[counts], readings[counts], others[counts]
        changes = np.flatnonzero(np.diff(values, prepend=self._last) != 0.0)
        for first, (start, stop) in enumerate(pairwise([0, *changes.tolist(), len(values)])):
            if first:
                self._longest = self._lasting()
                self._now = Same(0, float(time[start]))
            if stop > start:
                given = others[start:stop][np.isfinite(others[start:stop])]
                now = self._now
                self._now = Same(
                    now.samples + stop - start,
                    float(time[start]) if math.isnan(now.start) else now.start,
                    float(time[stop - 1]),
                    float(given.min(initial=now.least)),
                    float(given.max(initial=now.most)),
                )
        self._last = float(values[-1])

    def _lasting(self) -> list[Same]:
        return sorted((*self._longest, self._now), key=lambda each: each.samples, reverse=True)[:2]

    def loss(self) -> Loss | None:
        """Loss where the reading stayed the same for unusually long; None where it did not."""
        longest, *others = self._lasting()
        second = others[0].samples if others else 0
        changed = longest.most - longest.least
        never = longest.samples > UNHEARD * second and changed > 0.0
        least = SHORT if never else math.inf if self._noisy else SHORT if changed > TURNED else LONG
        if longest.samples * self._period < least or not longest.samples > UNUSUAL * second > 0.0:
            return None
        return _same(longest.start, longest.end, "of driving")


def stuck_readings(spans: Iterable[Stuck]) -> dict[str, Loss]:
    """Sensors whose readings stayed the same while related signals moved, at the first such time of each."""
    found: dict[str, Loss] = {}
    for each in spans:
        if each.name in SENSORS:
            found.setdefault(each.name, _same(each.start, each.end, "while related signals moved"))
    return found


def _same(start: float, end: float | None, while_: str) -> Loss:
    until = "on" if end is None else f"to {end:.2f} s"
    return Loss(Status.NOT_TESTABLE, f"its reading stayed the same from {start:.2f} s {until} {while_}", start, end)


LOST = 1.0  # time without a reading from which a signal is missing and not merely slow [s]
UNASKED = 0.06
"""Time without a target from which the cause of the motion is unknown [s]; 0.1 s later sensors would be declared."""
ALL = 4
"""Least number of sensors for the declaration of a fault; if so many or more read exactly zero or repeat themselves,
all of them at once, a shared part such as a bus or a supply has failed."""
HELD = 0.06
"""Time for which all sensors must repeat their readings for a shared failure [s]: a logger holds the last bus values.

With noise they would differ; without noise, repeated readings hold no information, and nothing is lost.
"""
PARKING = 1.5
"""Speed below which a vehicle was about to stand when its wheel speeds ended [m/s]; coarse sensors end at 0.8 m/s."""

_NEEDED = [*PLACES, *(ConditionSample._fields.index(name) for name in TARGETS)]
_WHEELS = [SENSORS.index(name) for name in ALL_WHEELS]
_COUNT = len(SENSORS)


class Covered(NamedTuple):
    """Coverage over n samples."""

    available: np.ndarray  # whether every sensor is read, and the target of every actuator is known, (n, elements)
    judged: np.ndarray  # whether anything can be judged, (n,)
    zero: np.ndarray  # whether all sensors read exactly zero, (n,)
    held: np.ndarray  # whether all sensors repeat their previous readings, (n,)
    parked: np.ndarray  # whether the vehicle stands, or was about to stand when its wheel speeds ended, (n,)
    enough: np.ndarray  # whether `ALL` sensors have been read so far, (n,)


class Coverage:
    """Follows which signals are available; the result does not depend on how a recording is cut into pieces.

    Without the targets the cause of a motion is unknown, and the sensors would be declared faulty for it.
    """

    def __init__(self, rate: float, asked: bool = True):
        self.interruptions, self._asked = 0, asked
        self._limits = np.where(np.arange(len(_NEEDED)) < _COUNT, round(LOST * rate), round(UNASKED * rate))
        self._held_limit = round(HELD * rate)
        self._age = np.full(len(_NEEDED), np.inf)
        self._judged, self._ever = False, np.zeros(_COUNT, bool)
        self._before, self._repeated = np.full(_COUNT, np.nan), 0
        self._parked: bool | None = None

    def add(self, values: np.ndarray) -> tuple[np.ndarray, Covered]:
        if not len(values):
            no = np.zeros(0, bool)
            return values, Covered(np.zeros((0, len(self._limits)), bool), no, no, no, no, no)
        readings = values[:, PLACES]
        zero, parked = all_zero(readings), self._stands(readings[:, _WHEELS])
        # A parked vehicle may repeat its readings without a fault.
        held = self._repeats(readings) & ~zero & ~parked
        if zero.any() or held.any():
            values = values.copy()
            values[np.ix_(zero | held, PLACES)] = np.nan
        there = np.isfinite(values[:, _NEEDED])
        # In indices of this piece, the last reading of the previous one lies at -1 - age.
        place = np.arange(len(values), dtype=float)[:, None]
        age = place - np.maximum.accumulate(np.where(there, place, -1.0 - self._age), axis=0)
        fresh = np.asarray(age <= self._limits)
        judged = np.asarray(fresh[:, :_COUNT].any(axis=1) & (fresh[:, _COUNT:].all(axis=1) | (not self._asked)))
        ever = np.logical_or.accumulate(there[:, :_COUNT], axis=0) | self._ever
        before = np.concatenate([[self._judged], judged[:-1]])
        self.interruptions += int(np.count_nonzero(before & ~judged))
        self._age, self._judged, self._ever = age[-1], bool(judged[-1]), ever[-1]
        return values, Covered(fresh, judged, zero, held, parked, ever.sum(axis=1) >= ALL)

    def _repeats(self, readings: np.ndarray) -> np.ndarray:
        """Whether all available sensors have repeated their readings for the time `HELD`, (n,)."""
        before = np.vstack([self._before, readings[:-1]])
        there = np.isfinite(readings) & np.isfinite(before)
        same = (there.sum(axis=1) >= ALL) & (~there | (readings == before)).all(axis=1)
        place = np.arange(len(readings))
        since = np.maximum.accumulate(np.where(same, -1 - self._repeated, place))
        repeated = place - since
        self._before, self._repeated = readings[-1], int(repeated[-1])
        return np.asarray(repeated >= self._held_limit)

    def _stands(self, wheels: np.ndarray) -> np.ndarray:
        """Whether the last speed other than zero was slow, or all speeds have been zero so far, (n,)."""
        speed = np.where(np.isfinite(wheels), np.abs(wheels), -1.0).max(axis=1, initial=-1.0)
        slow = np.where(speed > 0.0, speed < PARKING, True)
        known = (speed > 0.0) | ((speed == 0.0) & (np.cumsum(speed > 0.0) == 0) & (self._parked is None))
        place = np.maximum.accumulate(np.where(known, np.arange(len(speed)), -1))
        stands = np.where(place < 0, bool(self._parked), slow[place])
        if known.any():
            self._parked = bool(stands[-1])
        return np.asarray(stands)


def all_zero(readings: np.ndarray) -> np.ndarray:
    """Whether all available sensors read exactly zero: a failed bus or supply, or a vehicle at standstill."""
    there = np.isfinite(readings)
    return np.asarray((there.sum(axis=1) >= ALL) & (~there | (readings == 0.0)).all(axis=1))


class ImpossibleValues:
    """Removes infinite values, and values far beyond the plausible range of their signal, piece by piece."""

    def __init__(self) -> None:
        self._count = np.zeros(len(ConditionSample._fields), int)
        self._largest = np.zeros(len(ConditionSample._fields))

    def add(self, values: np.ndarray) -> np.ndarray:
        pairs = zip(ConditionSample._fields, values.T, strict=True)
        far = np.column_stack([impossible(name, column) for name, column in pairs])
        if not far.any():
            return values
        self._count += far.sum(axis=0)
        self._largest = np.maximum(self._largest, np.where(far, np.abs(values), 0.0).max(axis=0))
        return np.where(far, np.nan, values)

    def notes(self) -> tuple[str, ...]:
        return tuple(
            f"{count} impossible value{'s' if count > 1 else ''} of {name.replace('_', ' ')}, up to "
            + f"{largest:.3g} {SIGNALS[name].unit}".rstrip()
            + f" {'was' if count == 1 else 'were'} left out: check the sensor, its bus and its unit"
            for name, count, largest in zip(ConditionSample._fields, self._count.tolist(), self._largest, strict=True)
            if count
        )


SLOWEST = 40.0
"""Least rate of the targets for a judgement [Hz].

Ten minutes of a calibrated demonstrator, whose control runs at 100 Hz, are healthy with targets recorded at 50 Hz; at
33 Hz the fault-free sensor of the steering torque would be declared for 90 s of them. Sensors may come at 20 Hz.
"""

_PLACES = [ConditionSample._fields.index(name) for name in TARGETS]


class TargetPace:
    """Measures the mean sampling interval of each target; gaps longer than `LOST` are losses and do not count."""

    def __init__(self, rate: float):
        self._rate = rate
        self._age = np.full(len(TARGETS), np.inf)
        self._apart, self._count = np.zeros(len(TARGETS)), np.zeros(len(TARGETS))

    def add(self, values: np.ndarray) -> None:
        """Add the next piece, columns of `ConditionSample`, (n, signals); NaN if missing."""
        for place, column in enumerate(_PLACES):
            there = np.flatnonzero(np.isfinite(values[:, column]))
            apart = np.diff(np.concatenate(([-self._age[place]], there)))
            apart = apart[apart <= LOST * self._rate]
            self._apart[place] += apart.sum()
            self._count[place] += len(apart)
            self._age[place] = len(values) - there[-1] if len(there) else self._age[place] + len(values)

    def problems(self) -> tuple[Problem, ...]:
        rates = self._rate * self._count / np.maximum(self._apart, 1.0)
        slow = [name for name, rate, count in zip(TARGETS, rates, self._count, strict=True) if count and rate < SLOWEST]
        if not slow:
            return ()
        rate = min(rates[TARGETS.index(name)] for name in slow)
        which = "targets of the actuators are sampled" if len(slow) > 1 else f"{slow[0]} is sampled"
        cause = f"the {which} at {rate:.3g} Hz: between the samples the torque of the actuators is unknown"
        return (Problem("rate", (), cause, f"record {', '.join(slow)} at 50 Hz or faster"),)
