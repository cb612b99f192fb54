"""Losses of signals that were there before: since when, and for how much of the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Status

LEAST = 1.0
"""For which something must lack while the vehicle drives, beyond a gap that is borne, before it is called gone [s]."""


class Loss(NamedTuple):
    """Absence of a sensor, an actuator's target, or a signal that the whole judgement needs, over part of the drive.

    Args:
        status: of what is lost
        cause: in words
        since: for good from then on; None where it came back, and lacked for most of the drive
    """

    status: Status
    cause: str
    since: Annotated[float, "s"] | None


@dataclass
class Absence:
    """Follows whether something is there, piece by piece; while the vehicle is parked nothing lacks.

    Args:
        period: of the samples [s]
        borne: gap after which it is no longer taken to be there [s]
        there, lacked: samples of driving with and without it
        lately: those without it since it was there for the last time
        last: time at which it was [s]; NaN where it never was
    """

    period: float
    borne: float
    there: int = 0
    lacked: int = 0
    lately: int = 0
    last: float = math.nan

    def add(self, time: np.ndarray, there: np.ndarray, parked: np.ndarray) -> None:
        """The next piece: time [s], whether it is there, whether the vehicle is parked, (n,) each."""
        lacks = ~there & ~parked
        self.there += int(np.count_nonzero(there & ~parked))
        self.lacked += int(np.count_nonzero(lacks))
        places = np.flatnonzero(there)
        if len(places):
            self.last, self.lately = float(time[places[-1]]), 0
            lacks = lacks[places[-1] + 1 :]
        self.lately += int(np.count_nonzero(lacks))

    @property
    def came(self) -> bool:
        """Whether it was ever there."""
        return not math.isnan(self.last)

    @property
    def since(self) -> float | None:
        """Time from which the signal was absent to the end [s]; None where it was there at the end, or never."""
        return (
            max(self.last - self.borne + self.period, 0.0) if self.came and self.lately * self.period > LEAST else None
        )

    @property
    def mostly(self) -> bool:
        """Whether it came, and lacked for more of the drive than it was there."""
        return self.came and self.lacked > self.there and self.lacked * self.period > LEAST

    def loss(self, status: Status, gone: str, rare: str) -> Loss | None:
        """The loss in words, if there is one.

        Args:
            status: of what is lost
            gone: in words, what is the case since it is gone
            rare: in words, what is so for a part of the drive only
        """
        if self.since is not None:
            return Loss(status, f"{gone} since {self.since:.2f} s", self.since)
        if self.mostly:
            whole = (self.there + self.lacked) * self.period
            return Loss(status, f"{rare} for only {self.there * self.period:.0f} of {whole:.0f} s of driving", None)
        return None
