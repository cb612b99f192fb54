"""Presence of a monitor's input signals: where one is missing while others go on, and how much could be judged."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Annotated

import numpy as np

from tierod.core.facts import Fact
from tierod.core.findings import Status
from tierod.core.recording import Aligned
from tierod.methods.running import Share, Span, Spans
from tierod.monitors.harness.stuck_over_drive import Stuck

LEAST: Annotated[float, "s"] = 1.0  # shortest missing stretch that is reported
STEPS = 5.0  # shortest missing stretch of a slow signal, in its own sampling intervals
NAMED = 3  # most stretches of one signal that a sentence lists; further ones are counted


class MissingStretches:
    """Where each input signal of a monitor pauses, on the monitor's grid of `rate` [Hz].

    Lengths are counted in samples, since time without any recorded signal is skipped.
    """

    def __init__(self, names: Collection[str], rate: float):
        self.rate = rate
        self._missing = {name: Spans(LEAST * rate) for name in names}
        self._there = {name: Share() for name in names}
        self._begin = math.nan

    def add(self, aligned: Aligned) -> None:
        """Add the next samples, as the monitor receives them."""
        if len(aligned.time) and math.isnan(self._begin):
            self._begin = float(aligned.time[0])
        for name, spans in self._missing.items():
            if name in aligned.names:
                spans.add(aligned.time, ~aligned.there[name])
                self._there[name].add(aligned.time, aligned.there[name])

    def warnings(self, rates: Mapping[str, float], others: Collection[str] = ()) -> tuple[str, ...]:
        """Missing stretches, and the consequence for the verdict.

        Args:
            rates: sampling rates of the signals [Hz]
            others: signals that another warning names
        """
        sentences = []
        for name, spans in self._missing.items():
            rate = rates.get(name, math.nan)
            least = max(LEAST, STEPS / rate) if rate > 0.0 else LEAST
            found = [each for each in spans.found() if each.samples > least * self.rate]
            if self._there[name].true and name not in others and found:
                more = f" and {len(found) - NAMED} more times" if len(found) > NAMED else ""
                listed = ", ".join(map(self._when, found[:NAMED]))
                means = "estimates there rest on the other signals, or are held"
                sentences.append(f"{name} is missing {listed}{more}: {means}; check the sensor and its messages")
        return tuple(sentences)

    def _when(self, each: Span) -> str:
        if math.isinf(each.end):
            return f"from {each.start:.1f} s on ({each.samples / self.rate:.3g} s to the end)"
        if each.start <= self._begin:
            return f"until {each.end:.1f} s"
        return f"from {each.start:.1f} s to {each.end:.1f} s"


class JudgedTime:
    """Samples in which a monitor had all required signals: a verdict does not cover the time after the loss of one."""

    def __init__(self, required: Sequence[str], rate: float):
        self.required, self.rate = tuple(required), rate
        self.end: float | None = None
        self._complete, self._whole = Share(), Share()
        self._each = {name: Share() for name in required}

    @property
    def last(self) -> float | None:
        """Time of the last sample with all required signals [s]."""
        return self._complete.last

    @property
    def rest(self) -> float:
        """Time at the end of the recording in which nothing was judged [s]."""
        return 0.0 if self.last is None or self.end is None else self.end - self.last

    def add(self, aligned: Aligned, used: Collection[str] = ()) -> None:
        """Add the next samples, in which the monitor also uses some optional signals."""
        if not len(aligned.time):
            return
        self.end = float(aligned.time[-1])
        complete = np.ones(len(aligned.time), bool)
        for name, share in self._each.items():
            if name in aligned.names:
                complete &= aligned.there[name]
                share.add(aligned.time, aligned.there[name])
        self._complete.add(aligned.time, complete)
        for name in used:
            if name in aligned.names:
                complete = complete & aligned.there[name]
        self._whole.add(aligned.time, complete)

    def evidence(self) -> dict[str, float]:
        """Shares and times of complete signals, as evidence of a finding."""
        count = max(self._whole.count, 1)
        shares = {"signals_complete_share": self._whole.true / count}
        if self._complete.true != self._whole.true:
            shares["required_signals_share"] = self._complete.true / count
        return shares | ({} if self._whole.last is None else {"signals_complete_until_s": self._whole.last})

    def lost(self, reaction: float, stuck: Mapping[str, Stuck]) -> Fact | None:
        """Fact that the end of the recording was not judged for longer than a fault may need; None where it was.

        Args:
            reaction: time that the monitor needs to find a fault [s]
            stuck: signals that are stuck until the end, by name
        """
        if not self.rest > reaction or self.last is None or self.end is None:
            return None
        lasts = {name: self.last if share.last is None else share.last for name, share in self._each.items()}
        lost = [name for name, last in lasts.items() if last <= self.last + 1.5 / self.rate]
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
