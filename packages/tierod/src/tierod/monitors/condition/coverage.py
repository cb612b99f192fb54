"""Coverage of a recording: possible values, enough sensors, losses of signals, and readings that stay the same."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.io.quality import impossible
from tierod.methods.running import Spans
from tierod.monitors.condition.signals import ALL_WHEELS, PLACES, SENSORS, TARGETS, ConditionSample
from tierod.monitors.condition.wiring import Problem, wrong_unit
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
    alone: Spans = field(init=False)  # times without it while other signals were judged

    def __post_init__(self) -> None:
        self.alone = Spans(LEAST / self.period)

    def add(self, time: np.ndarray, there: np.ndarray, parked: np.ndarray, others: np.ndarray | None = None) -> None:
        lacks = ~there & ~parked
        places = np.flatnonzero(there)
        if others is not None:
            # Before its first presence the signal has not begun, which is no gap.
            begun = np.ones(len(time), bool) if self.came else np.logical_or.accumulate(there)
            self.alone.add(time, lacks & others & begun)
        self.there += int(np.count_nonzero(there & ~parked))
        self.lacked += int(np.count_nonzero(lacks))
        if len(places):
            self.last, self.lately = float(time[places[-1]]), 0
            lacks = lacks[places[-1] + 1 :]
        self.lately += int(np.count_nonzero(lacks))

    @property
    def came(self) -> bool:
        return not math.isnan(self.last)

    @property
    def since(self) -> float | None:
        """Time from which the signal is missing until the end [s]; None if it was present at the end, or never."""
        lost = self.came and self.lately * self.period > LEAST
        return self._begun(self.last + self.period) if lost else None

    def _begun(self, noticed: float) -> float:
        return max(noticed - self.borne, 0.0)

    def loss(self, status: Status, gone: str, rare: str) -> Loss | None:
        """Loss until the end, or for more than half of the drive, in words; None if there is none."""
        if self.since is not None:
            return Loss(status, f"{gone} since {self.since:.2f} s", self.since)
        if self.came and self.lacked > self.there and self.lacked * self.period > LEAST:
            whole = (self.there + self.lacked) * self.period
            return Loss(status, f"{rare} for only {self.there * self.period:.0f} of {whole:.0f} s of driving", None)
        gaps = [each for each in self.alone.found() if math.isfinite(each.end)]
        if not gaps:
            return None
        start, end, further = self._begun(gaps[0].start), gaps[0].end, len(gaps) - 1
        more = f", and {further} more time{'s' * (further > 1)}" if further else ""
        return Loss(Status.NOT_TESTABLE, f"{gone} from {start:.2f} s to {end:.2f} s{more}", start, end)


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
    start: Annotated[float, "s"] = math.nan  # start, end: first sample of driving, and last sample [s]
    end: Annotated[float, "s"] = math.nan
    least: float = math.inf  # least, most: range of the value by other sensors in it [unit of the reading]
    most: float = -math.inf


class Constancy:
    """Follows piece by piece for how long the reading stays exactly the same; only driving counts.

    A sensor that fails to a plausible value, such as a yaw rate of zero on a straight road, contradicts no other.
    """

    def __init__(self, period: float, noisy: bool = False):
        self._period, self._last, self._noisy = period, math.nan, noisy
        self._now = Same()
        self._longest: list[Same] = []

    def add(self, time: np.ndarray, readings: np.ndarray, moving: np.ndarray, others: np.ndarray) -> None:
        there = np.flatnonzero(np.isfinite(readings))
        if not len(there):
            return
        time, values, moving, others = time[there], readings[there], moving[there], others[there]
        changes = np.flatnonzero(np.diff(values, prepend=self._last) != 0.0)
        for first, (start, stop) in enumerate(pairwise([0, *changes.tolist(), len(values)])):
            if first:
                self._longest, self._now = self._lasting(), Same()
            drives = time[start:stop][moving[start:stop]]
            now = self._now
            if len(drives) or (now.samples and stop > start):
                given = others[start:stop][moving[start:stop] & np.isfinite(others[start:stop])]
                self._now = Same(
                    now.samples + len(drives),
                    float(drives[0]) if math.isnan(now.start) else now.start,
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
        return _same(longest.start, None if longest is self._now else longest.end)


def stuck_readings(spans: Iterable[Stuck]) -> dict[str, Loss]:
    """Sensors whose readings stayed the same while related signals moved, at the first such time of each."""
    found: dict[str, Loss] = {}
    for each in spans:
        if each.name in SENSORS:
            found.setdefault(each.name, _same(each.start, each.end, " while related signals moved"))
    return found


def _same(start: float, end: float | None, while_: str = "") -> Loss:
    until = "on" if end is None else f"to {end:.2f} s"
    return Loss(Status.NOT_TESTABLE, f"its reading stayed the same from {start:.2f} s {until}{while_}", start, end)


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

_TARGETS = [ConditionSample._fields.index(name) for name in TARGETS]
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
        self._limits = np.repeat((round(LOST * rate), round(UNASKED * rate)), (_COUNT, len(TARGETS)))
        self._held_limit = round(HELD * rate)
        self._age = np.full(len(self._limits), np.inf)
        self._judged, self._ever = False, np.zeros(_COUNT, bool)
        self._before, self._repeated = np.full(_COUNT, np.nan), 0
        self._parked: bool | None = None

    def add(self, values: np.ndarray) -> tuple[np.ndarray, Covered]:
        if not len(values):
            no = np.zeros(0, bool)
            return values, Covered(np.zeros((0, len(self._limits)), bool), no, no, no, no, no)
        readings = values[:, PLACES]
        present = np.isfinite(readings)
        # A failed bus or supply, or a vehicle at standstill.
        zero = (present.sum(axis=1) >= ALL) & (~present | (readings == 0.0)).all(axis=1)
        parked = self._stands(readings[:, _WHEELS])
        # A parked vehicle may repeat its readings without a fault.
        held = self._repeats(readings) & ~zero & ~parked
        if zero.any() or held.any():
            values = values.copy()
            values[np.ix_(zero | held, PLACES)] = np.nan
        there = np.isfinite(values[:, [*PLACES, *_TARGETS]])
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
        repeated = place - np.maximum.accumulate(np.where(same, -1 - self._repeated, place))
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


SPIKES = 1.0  # time of impossible values from which they are no spikes, but values of another unit [s]


class ImpossibleValues:
    """Removes infinite values, and values far beyond the plausible range of their signal, piece by piece."""

    def __init__(self, rate: float) -> None:
        self._spikes = SPIKES * rate
        self._count, self._largest = (np.zeros(len(ConditionSample._fields)) for _ in range(2))

    def add(self, values: np.ndarray) -> np.ndarray:
        pairs = zip(ConditionSample._fields, values.T, strict=True)
        far = np.column_stack([impossible(name, column) for name, column in pairs])
        if not far.any():
            return values
        self._count += far.sum(axis=0)
        self._largest = np.maximum(self._largest, np.where(far, np.abs(values), 0.0).max(axis=0))
        return np.where(far, np.nan, values)

    def _found(self) -> list[tuple[str, int, float]]:
        rows = zip(ConditionSample._fields, self._count.astype(int).tolist(), self._largest.tolist(), strict=True)
        return [row for row in rows if row[1]]

    def notes(self) -> tuple[str, ...]:
        return tuple(
            f"{count} impossible value{'s' if count > 1 else ''} of {name.replace('_', ' ')}, up to "
            + f"{largest:.3g} {SIGNALS[name].unit}".rstrip()
            + f" {'was' if count == 1 else 'were'} left out: check the sensor, its bus and its unit"
            for name, count, largest in self._found()
        )

    def problems(self, names: Collection[str]) -> tuple[Problem, ...]:
        """Problem that a signal has another unit, as degrees for radians, in which its values are possible."""
        for name, count, largest in self._found():
            unit = SIGNALS[name].unit
            factor = shown(unit)[0]
            possible = factor > 1.0 and not impossible(name, np.array([largest / factor])).any()
            if name in names and count > self._spikes and possible:
                return (wrong_unit((name,), f"{largest:.3g} {unit} is impossible"),)
        return ()


SLOWEST = 40.0
"""Least rate of the targets for a judgement [Hz].

Ten minutes of a calibrated demonstrator, whose control runs at 100 Hz, are healthy with targets recorded at 50 Hz; at
33 Hz the fault-free sensor of the steering torque would be declared for 90 s of them. Sensors may come at 20 Hz.
"""


class TargetPace:
    """Measures the mean sampling interval of each target; gaps longer than `LOST` are losses and do not count."""

    def __init__(self, rate: float):
        self._rate = rate
        self._age = np.full(len(TARGETS), np.inf)
        self._apart, self._count = np.zeros(len(TARGETS)), np.zeros(len(TARGETS))

    def add(self, values: np.ndarray) -> None:
        """Add the next piece, columns of `ConditionSample`, (n, signals); NaN if missing."""
        for place, column in enumerate(_TARGETS):
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
