"""Losses of signals during a drive: since when, and for how much of the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status

LEAST = 1.0
"""Time of driving, beyond a tolerated gap, for which a signal must be missing to count as lost [s]."""


class Loss(NamedTuple):
    """Loss of a sensor, an actuator's target, or a signal that the whole judgement needs, over part of the drive.

    Args:
        status: status of the affected element
        cause: cause in words
        since: start of the loss; None if the signal came and went, and was missing for most of the drive
        until: end of the loss; None if it lasted until the end of the drive
    """

    status: Status
    cause: str
    since: Annotated[float, "s"] | None
    until: Annotated[float, "s"] | None = None


@dataclass
class Absence:
    """Follows the presence of a signal piece by piece; while the vehicle is parked it does not count as missing.

    Args:
        period: sampling interval [s]
        borne: longest tolerated gap, by which presence is reported too long [s]
        there, lacked: number of samples of driving with and without the signal
        lately: number of samples of driving without it since it was last present
        last: time at which it was last present [s]; NaN if it never was
        alone: number of samples of driving without it alone, since it was last present
        gaps: bounds of the times without it alone, after which it came back [s]
    """

    period: float
    borne: float
    there: int = 0
    lacked: int = 0
    lately: int = 0
    last: float = math.nan
    alone: int = 0
    gaps: list[tuple[float, float]] = field(default_factory=list)

    def add(self, time: np.ndarray, there: np.ndarray, parked: np.ndarray, others: np.ndarray | None = None) -> None:
        """Add the next piece, (n,) each.

        Args:
            time: time [s]
            there: whether the signal is present
            parked: whether the vehicle is parked
            others: whether other signals are present; None if gaps are not wanted
        """
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
        """Whether the signal was ever present."""
        return not math.isnan(self.last)

    @property
    def since(self) -> float | None:
        """Time from which the signal is missing until the end [s]; None if it was present at the end, or never."""
        return (
            max(self.last - self.borne + self.period, 0.0) if self.came and self.lately * self.period > LEAST else None
        )

    @property
    def mostly(self) -> bool:
        """Whether the signal was present, but missing for more than half of the drive."""
        return self.came and self.lacked > self.there and self.lacked * self.period > LEAST

    def loss(self, status: Status, gone: str, rare: str) -> Loss | None:
        """Loss in words; None if there is none.

        Args:
            status: status of the affected element
            gone: description of the time since the loss, in words
            rare: description of the time with the signal, in words
        """
        if self.since is not None:
            return Loss(status, f"{gone} since {self.since:.2f} s", self.since)
        if self.mostly:
            whole = (self.there + self.lacked) * self.period
            return Loss(status, f"{rare} for only {self.there * self.period:.0f} of {whole:.0f} s of driving", None)
        if self.gaps:
            (start, end), *further = self.gaps
            more = f", and {len(further)} more time{'s' * (len(further) > 1)}" if further else ""
            return Loss(Status.NOT_TESTABLE, f"{gone} from {start:.2f} s to {end:.2f} s{more}", start, end)
        return None
