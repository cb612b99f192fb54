"""Judged part of a recording: a verdict does not cover the time after the loss of a required signal."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from tierod.core.facts import Fact
from tierod.core.findings import Status
from tierod.core.recording import Aligned
from tierod.core.series import last_true
from tierod.monitors.harness.stuck_over_drive import Stuck


class JudgedTime:
    """Counts the samples in which a monitor had all required signals.

    Args:
        required: signals without which the monitor judges nothing
        rate: rate of its grid [Hz]

    `last` is the time of the last sample with all of them, `end` the time of the last sample [s].
    """

    def __init__(self, required: Sequence[str], rate: float):
        self.required, self.rate = tuple(required), rate
        self.last: float | None = None
        self.end: float | None = None
        self._count = self._complete = self._whole = 0
        self._whole_last: float | None = None
        self._last: dict[str, float] = {}

    def add(self, aligned: Aligned, used: Collection[str] = ()) -> None:
        """Add the next samples.

        Args:
            aligned: samples as the monitor receives them
            used: optional signals that this recording has
        """
        if not len(aligned.time):
            return
        self._count += len(aligned.time)
        self.end = float(aligned.time[-1])
        complete = np.ones(len(aligned.time), bool)
        for name in self.required:
            if name not in aligned.names:
                continue
            there = aligned.there[name]
            complete &= there
            if (at := last_true(there)) is not None:
                self._last[name] = float(aligned.time[at])
        self._complete += int(np.count_nonzero(complete))
        if (at := last_true(complete)) is not None:
            self.last = float(aligned.time[at])
        for name in used:
            if name in aligned.names:
                complete &= aligned.there[name]
        self._whole += int(np.count_nonzero(complete))
        if (at := last_true(complete)) is not None:
            self._whole_last = float(aligned.time[at])

    @property
    def rest(self) -> float:
        """Time at the end of the recording in which nothing was judged [s]."""
        return 0.0 if self.last is None or self.end is None else self.end - self.last

    def evidence(self) -> dict[str, float]:
        """Shares and times of complete signals, as evidence of a finding."""
        count = max(self._count, 1)
        shares = {"signals_complete_share": self._whole / count}
        if self._complete != self._whole:
            shares["required_signals_share"] = self._complete / count
        return shares | ({} if self._whole_last is None else {"signals_complete_until_s": self._whole_last})

    def lost(self, reaction: float, stuck: Mapping[str, Stuck]) -> Fact | None:
        """Fact that the end of the recording was not judged for longer than a fault may need; None where it was.

        Args:
            reaction: time that the monitor needs to find a fault [s]
            stuck: signals that are stuck until the end, by name
        """
        if not self.rest > reaction or self.last is None or self.end is None:
            return None
        lost = [name for name in self.required if self._last.get(name, self.last) <= self.last + 1.5 / self.rate]
        since = min((stuck[name].start for name in lost if name in stuck), default=self.last)
        what = [f"{name} is {'stuck' if name in stuck else 'missing'}" for name in lost] or ["signals are lost"]
        return Fact(
            "judged time",
            f"{' and '.join(what)} from {since:.1f} s on, so nothing was judged after that ({self.end - since:.0f} s)",
            f"{what[0]} from {since:.1f} s on",
            "repair the sensor or its messages, and record again with all signals to the end",
            tuple(lost),
            Status.NOT_IDENTIFIABLE,
        )
