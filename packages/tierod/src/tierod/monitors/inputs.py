"""Checks of the input signals of a monitor over a recording, and the facts about them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np

from tierod.core.facts import GUESSES, LONGEST_REASON, REPAIR, Fact, assemble, weigh
from tierod.core.findings import Finding, Status
from tierod.core.graph import Memory, Scanner
from tierod.core.recording import Aligned, Recording
from tierod.core.series import Stride
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.io.derive import ingredients
from tierod.io.signs import MAGNITUDE, SIGN_FROM
from tierod.methods.relations import witnesses
from tierod.methods.running import (
    Share,
    Span,
    Spans,
)
from tierod.monitors.acceptance import other_vehicle
from tierod.monitors.defects import MAXIMUM_AGE, InputDefects
from tierod.monitors.pieces import QualityOverChunks
from tierod.monitors.session import Conclusion, Monitor, StatusChange
from tierod.monitors.stuck import Stuck, StuckSignals

LEAST: Annotated[float, "s"] = 1.0  # shortest missing stretch that is reported
STEPS = 5.0  # shortest missing stretch of a slow signal, in its own sampling intervals
NAMED = 3  # most stretches of one signal that a sentence lists; further ones are counted


# Rate at which signals are checked for being stuck [Hz]: enough, since a stuck one repeats its value in every sample,
# and cheap even beside a monitor at 10 kHz
WATCHED = 20.0


class StuckOverDrive:
    """Checks the input signals of a monitor; the result does not depend on how the recording is cut into pieces.

    Args:
        names: input signals of the monitor; only canonical signals are checked
        rate: rate of the monitor's grid [Hz]
    """

    def __init__(self, names: Collection[str], rate: float, passed_on: Collection[str] = ()):
        self.names = tuple(name for name in names if name in SIGNALS)
        self.beside = witnesses(self.names)
        self.passed_on = frozenset(passed_on)
        self._stride = Stride(max(round(rate / WATCHED), 1))
        self._rate = rate / self._stride.step
        self._block = StuckSignals(self.names, self.beside, 1.0 / self._rate) if self.names else None
        self._scanner = Scanner(self._block) if self._block else None
        self._memory: Memory | None = None
        self._flags = np.zeros(len(self.names), bool)
        self._open: dict[str, Stuck] = {}
        self._closed: list[Stuck] = []

    def without(self, aligned: Aligned, recording: Recording) -> Aligned:
        """Next samples of the monitor with NaN where a signal is stuck."""
        watched = self._stride.over(len(aligned.time))
        if self._block is None:
            return aligned
        kept = aligned.time[watched]
        # Row 0 is the state at the end of the previous piece, for samples before the first one that is checked here.
        flags = np.empty((len(kept) + 1, len(self.names)), bool)
        flags[0] = self._flags
        if len(kept):
            flags[1:] = self._watch(kept, recording)
            self._flags = flags[-1]
        if not flags.any():
            return aligned
        place = (np.arange(len(aligned.time)) - watched.start) // watched.step + 1
        values = aligned.values.copy()
        for column, name in enumerate(self.names):
            if name in aligned.names and name not in self.passed_on:
                values[flags[place, column], aligned.names.index(name)] = np.nan
        return replace(aligned, values=values)

    def spans(self) -> tuple[Stuck, ...]:
        """Spans in which signals were stuck, in the order of time."""
        return tuple(sorted((*self._closed, *self._open.values()), key=lambda each: (each.start, each.name)))

    def lasting(self) -> Mapping[str, Stuck]:
        """Signals that are still stuck, by name."""
        return dict(self._open)

    def facts(self, units: Mapping[str, str]) -> tuple[Fact, ...]:
        """Stuck signals with their spans and values, each with the remedy where it was removed."""
        found = []
        for name in dict.fromkeys(each.name for each in self.spans()):
            times = [each for each in self.spans() if each.name == name]
            listed = ", ".join(_when(each, units.get(name, "")) for each in times[:NAMED])
            others = len(times) - NAMED
            more = "" if others < 1 else " and once more" if others == 1 else f" and {others} more times"
            passed = name in self.passed_on
            used = "other signals show that it should have moved" if passed else "not used there"
            cause = f"{name} is stuck {listed}{more}: {used}; check the sensor and its messages"
            spans = f"{', '.join(map(_span, times[:NAMED]))}{' and later' * (others > 0)}"
            action = "" if passed else f"repair or check {name}: it was stuck {spans}"
            found.append(Fact("stuck", cause, action=action, rests_on=(name,)))
        return tuple(found)

    def _watch(self, kept: np.ndarray, recording: Recording) -> np.ndarray:
        """Whether each signal is stuck at the given times, (times, signals); also updates the spans."""
        assert self._block is not None
        stop = float(kept[-1]) + 0.5 / self._rate
        seen = recording.align(
            self._block.all_names, self._rate, maximum_age=MAXIMUM_AGE, start=float(kept[0]), stop=stop
        )
        assert self._scanner is not None
        result = self._scanner.scan(seen, self._memory)
        self._memory = result.state
        flags = result.values > 0.0
        before = np.vstack([self._flags, flags[:-1]])
        for at, column in np.argwhere(flags != before).tolist():
            name, time = self.names[column], float(kept[at])
            if flags[at, column]:
                value = float(seen.values[at, column])
                self._open[name] = Stuck(name, time - float(result.values[at, column]), time, None, value)
            else:
                self._closed.append(replace(self._open.pop(name), end=time))
        return flags


def _span(each: Stuck) -> str:
    return f"from {each.start:.1f} s {'on' if each.end is None else f'to {each.end:.1f} s'}"


def _when(each: Stuck, unit: str) -> str:
    return f"at {in_words(each.value, unit, 4)} {_span(each)}"


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
        """Missing stretches, and the consequence for the verdict."""
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
        """Fact that the end of the recording was not judged for longer than a fault may need; None where it was."""
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


class InputChecks:
    """Checks the input signals piece by piece beside the monitor, and states the facts about them.

    `needs` holds the names of the channels to be read.
    """

    def __init__(self, monitor: Monitor, signals: Sequence[str]):
        used = ingredients([*monitor.required, *monitor.optional])
        self.monitor = monitor
        self.quality = QualityOverChunks(used)
        self.stuck = StuckOverDrive(signals, monitor.rate, monitor.subjects)
        self.judged = JudgedTime(monitor.required, monitor.rate)
        self.missing = MissingStretches([name for name in signals if name not in monitor.subjects], monitor.rate)
        self._there: set[str] = set()
        self.defects = InputDefects(self.stuck.names)
        self.needs = tuple(dict.fromkeys((*used, *self.stuck.beside)))
        self._paced = False

    def refuse_slow(self) -> None:
        """Refuse required signals with a low sampling rate; checks with every piece until all rates are known."""
        if not self._paced:
            self._paced = self.quality.refuse_slow(self.monitor.required, self.monitor.minimum_rate)

    def add(self, whole: Recording, start: float, usable: Aligned) -> None:
        """Add the next samples."""
        self._there.update(name for name in usable.names if name in whole)
        self.judged.add(usable, self._there)
        self.missing.add(usable)
        self.defects.add(whole, start, float(usable.time[-1]), self.stuck.spans())

    def found(
        self, conclusion: Conclusion, metadata: Mapping[str, Any], judged_as: str, others: Sequence[Fact] = ()
    ) -> tuple[Finding, Conclusion]:
        """Finding of a conclusion among the facts about its signals, and the conclusion that still holds then."""
        monitor, verdict = self.monitor, conclusion.verdict
        needed = {*monitor.required, *monitor.rests_on}
        stuck = {each.name for each in self.stuck.spans()}
        lost = self.judged.lost(monitor.reaction, self.stuck.lasting())
        before = (
            *self.defects.found(self.quality.units),
            # Of a stuck signal the monitor says itself from when on it was not used.
            *(each for each in others if needed.intersection(each.rests_on) and not stuck.intersection(each.rests_on)),
            *self._contradictions(),
        )
        limiting = (*before, *((lost,) if lost else ()))
        facts = (*limiting, *self._notes(metadata, judged_as))
        verdict = replace(verdict, evidence={**verdict.evidence, **self.judged.evidence()})
        finding = assemble(monitor.subject or monitor.title, verdict, facts, needed)
        course = conclusion.course
        if lost and self.judged.last is not None and finding.status is not weigh(verdict, before, needed).status:
            course = (*course, StatusChange(self.judged.last, finding.status))
        # A level that only guesses doubt may still be stored where the user knows better.
        weighed = weigh(verdict, limiting, needed)
        doubts = (*weighed.lowering, *(each for each in weighed.causes if each.doubts))
        unchanged = all(each.name == GUESSES for each in doubts)
        return finding, replace(
            conclusion,
            baseline=conclusion.baseline if unchanged else None,
            unproven=conclusion.unproven if unchanged else None,
            course=course,
        )

    def _contradictions(self) -> Iterator[Fact]:
        """Contradictions between signals, and noise, which explain why nothing was identifiable."""
        for each in self.quality.contradictions():
            name, magnitude, _ = each.partition(MAGNITUDE)
            if magnitude:
                reason, action = f"{name} has no sign", f"{SIGN_FROM}, and judge again"
                yield Fact("defect", each, reason, action, (name,), Status.NOT_IDENTIFIABLE, True, True, True)
            else:
                yield self._doubt(each, re.split(r" \(|: ", each)[0])
        for each in self.quality.noise_warnings():
            yield self._doubt(each, each.partition(" by ")[0])

    def _doubt(self, cause: str, reason: str) -> Fact:
        names = tuple(name for name in self.quality.names if name in cause)
        short = reason if len(reason.split()) <= LONGEST_REASON else ""
        return Fact("doubt", cause, short, REPAIR, names, explains=True)

    def _notes(self, metadata: Mapping[str, Any], judged_as: str) -> Iterator[Fact]:
        """What a reader must know of vehicle, input signals and recording, though it limits nothing."""
        if other := other_vehicle(metadata, judged_as):
            yield Fact("vehicle", other)
        yield from self.stuck.facts(self.quality.units)
        notes = (
            *self.missing.warnings(self.quality.rates(), {each.name for each in self.stuck.spans()}),
            *self.quality.range_warnings(),
            *self.quality.held_warnings(),
            *metadata.get("warnings", ()),
        )
        yield from (Fact("signals", each) for each in notes)
