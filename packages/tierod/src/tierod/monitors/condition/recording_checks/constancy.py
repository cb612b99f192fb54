"""A sensor whose reading stays exactly the same while the vehicle moves, far longer than at any other time."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status
from tierod.monitors.condition.recording_checks.absence import Loss
from tierod.monitors.condition.signals import SENSORS
from tierod.monitors.harness.stuck_over_drive import Stuck

LONG = 5.0
"""Time of driving for which a reading must stay the same [s]; coarse sensors on straight roads reach 3 s."""
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
    """Time in which the reading stayed the same.

    Args:
        samples: number of samples of driving
        start, end: bounds of the time [s]
        least, most: range of the value by other sensors in it [unit of the reading]
    """

    samples: int = 0
    start: Annotated[float, "s"] = math.nan
    end: Annotated[float, "s"] = math.nan
    least: float = math.inf
    most: float = -math.inf


class Constancy:
    """Follows piece by piece for how long the reading stays exactly the same; standstill and gaps do not count.

    A sensor that fails to a plausible value, such as a yaw rate of zero on a straight road, contradicts no other.

    Args:
        period: sampling interval [s]
        noisy: whether only a reading that otherwise never stays the same is judged: a driver may hold a speed, which a
            coarse sensor repeats
    """

    def __init__(self, period: float, noisy: bool = False):
        self._period, self._last, self._noisy = period, math.nan, noisy
        self._now = Same()
        self._longest: list[Same] = []

    def add(self, time: np.ndarray, readings: np.ndarray, moving: np.ndarray, others: np.ndarray) -> None:
        """Add the next piece, (n,) each.

        Args:
            time: time [s]
            readings: readings; NaN if missing
            moving: whether the vehicle moves
            others: value of the same signal by other sensors: of a yaw rate by the steering angle, of a wheel speed by
                all wheels [unit of the reading]; NaN if missing
        """
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
        """The two longest times, the longer one first."""
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
    """Sensors whose readings stayed the same while related signals moved, at the first such time of each.

    Args:
        spans: spans in which signals were stuck, in the order of time
    """
    found: dict[str, Loss] = {}
    for each in spans:
        if each.name in SENSORS:
            found.setdefault(each.name, _same(each.start, each.end, "while related signals moved"))
    return found


def _same(start: float, end: float | None, while_: str) -> Loss:
    until = "on" if end is None else f"to {end:.2f} s"
    return Loss(Status.NOT_TESTABLE, f"its reading stayed the same from {start:.2f} s {until} {while_}", start, end)
