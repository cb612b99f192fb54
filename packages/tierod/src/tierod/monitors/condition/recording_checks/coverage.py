"""Coverage of a recording: possible values, enough sensors, and targets of the actuators at a sufficient rate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.core.signals import SIGNALS
from tierod.io.quality import impossible
from tierod.monitors.condition.recording_checks.contradictions import Problem
from tierod.monitors.condition.signals import ALL_WHEELS, PLACES, SENSORS, TARGETS, ConditionSample

LOST = 1.0
"""Time without a reading from which a signal is missing and not merely slow [s]."""
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
    """Coverage over n samples.

    Args:
        available: whether every sensor is read, and the target of every actuator is known, (n, elements)
        judged: whether anything can be judged, (n,)
        zero: whether all sensors read exactly zero, (n,)
        held: whether all sensors repeat their previous readings, (n,)
        parked: whether the vehicle stands, or was about to stand when its wheel speeds ended, (n,)
        enough: whether `ALL` sensors have been read so far, (n,)
    """

    available: np.ndarray
    judged: np.ndarray
    zero: np.ndarray
    held: np.ndarray
    parked: np.ndarray
    enough: np.ndarray


class Coverage:
    """Follows which signals are available; the result does not depend on how a recording is cut into pieces.

    Without the targets the cause of a motion is unknown, and the sensors would be declared faulty for it.

    Args:
        rate: sampling rate [Hz]
        asked: whether the targets are needed; they are not if the filters allow any motion
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
        """Add the next piece.

        Args:
            values: columns of `ConditionSample`, (n, signals); NaN if missing

        Returns:
            the values, NaN during a shared failure of all sensors, and their coverage
        """
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
    """Whether all available sensors read exactly zero: a failed bus or supply, or a vehicle at standstill.

    Args:
        readings: readings, (n, sensors); NaN if missing
    """
    there = np.isfinite(readings)
    return np.asarray((there.sum(axis=1) >= ALL) & (~there | (readings == 0.0)).all(axis=1))


class ImpossibleValues:
    """Removes infinite values, and values far beyond the plausible range of their signal, piece by piece."""

    def __init__(self) -> None:
        self._count = np.zeros(len(ConditionSample._fields), int)
        self._largest = np.zeros(len(ConditionSample._fields))

    def add(self, values: np.ndarray) -> np.ndarray:
        """Next piece with NaN in place of impossible values.

        Args:
            values: columns of `ConditionSample`, (n, signals); NaN if missing
        """
        pairs = zip(ConditionSample._fields, values.T, strict=True)
        far = np.column_stack([impossible(name, column) for name, column in pairs])
        if not far.any():
            return values
        self._count += far.sum(axis=0)
        self._largest = np.maximum(self._largest, np.where(far, np.abs(values), 0.0).max(axis=0))
        return np.where(far, np.nan, values)

    def notes(self) -> tuple[str, ...]:
        """Sentences on the removed values."""
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
    """Measures the mean sampling interval of each target; gaps longer than `LOST` are losses and do not count.

    Args:
        rate: sampling rate of the grid [Hz]
    """

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
        """Problem that the rate of targets is too low; empty if it is not."""
        rates = self._rate * self._count / np.maximum(self._apart, 1.0)
        slow = [name for name, rate, count in zip(TARGETS, rates, self._count, strict=True) if count and rate < SLOWEST]
        if not slow:
            return ()
        rate = min(rates[TARGETS.index(name)] for name in slow)
        which = "targets of the actuators are sampled" if len(slow) > 1 else f"{slow[0]} is sampled"
        cause = f"the {which} at {rate:.3g} Hz: between the samples the torque of the actuators is unknown"
        return (Problem("rate", (), cause, f"record {', '.join(slow)} at 50 Hz or faster"),)
