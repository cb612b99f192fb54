"""Checks of the input signals of a monitor over a recording, and the facts about them."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np

from tierod.core.facts import GUESSES, LONGEST_REASON, REPAIR, Fact, assemble, defect, weigh
from tierod.core.findings import Finding, Status
from tierod.core.recording import Aligned, Recording
from tierod.core.shown import in_words
from tierod.core.signals import residue_of
from tierod.io.derive import ingredients
from tierod.methods.relations import CERTAIN, CORRELATION, FOLLOWS, RELATIONS
from tierod.methods.running import (
    BLOCK,
    RATE,
    Blocks,
    Lag,
    LaggedCorrelation,
    OuterLevels,
    Share,
    Span,
    Spans,
    piles_up,
)
from tierod.monitors.acceptance import other_vehicle
from tierod.monitors.pieces import QualityOverChunks
from tierod.monitors.session import Conclusion, Monitor, StatusChange
from tierod.monitors.stuck import MAXIMUM_AGE, Stuck, StuckOverDrive

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


AT_ONCE = 30 * BLOCK  # samples that are aligned at once, 10 min: a pause of many hours need not fit into memory
CHECKED = ("steering", "turn", "fast turn", "car", "road", "assist")  # relations that are checked over a drive

# Signals that are checked for clipping: their free motion has no preferred extreme, unlike an angle with stops or a
# speed that rests at zero
CLIPPED = ("driver_torque", "motor_torque", "lateral_acceleration", "yaw_rate", "steering_wheel_rate")

SHORTEST_CLIPPED = 1.0  # Total time at the extreme value from which a signal counts as clipped [s]

# Least share of that time in the drive [-], so that a motor at its limit in a single manoeuvre does not count
SHARE_CLIPPED = 0.005


class InputDefects:
    """Compares input signals over a drive; the result does not depend on how the recording is cut into pieces."""

    def __init__(self, names: Sequence[str]):
        pairs = {key: RELATIONS[key] for key in CHECKED if RELATIONS[key].signals <= set(names)}
        self._lags = {key: LaggedCorrelation(each.smallest) for key, each in pairs.items()}
        self._ends = {name: OuterLevels() for name in CLIPPED if name in names}
        used = [name for each in pairs.values() for name in (*each.first, *each.second)]
        self.names = tuple(dict.fromkeys((*used, *self._ends)))
        self._samples = 0
        self._blocks = Blocks(BLOCK, len(self.names))

    def add(self, recording: Recording, start: float, until: float, stuck: Iterable[Stuck] = ()) -> None:
        """Add the next piece."""
        if not self.names:
            return
        spans = tuple(each for each in stuck if each.name in self.names)
        while (first := start + self._samples / RATE) <= until:
            stop = min(until + 1e-6, first + (AT_ONCE - 0.5) / RATE)
            aligned = recording.align(self.names, RATE, maximum_age=MAXIMUM_AGE, start=first, stop=stop)
            self._samples += len(aligned.time)
            for each in spans:
                end = np.inf if each.end is None else each.end
                without = (aligned.time >= each.found) & (aligned.time < end)
                aligned.values[without, self.names.index(each.name)] = np.nan
            for block in self._blocks.add(aligned.values):
                self._take(dict(zip(self.names, block.T, strict=True)))

    def _take(self, block: Mapping[str, np.ndarray]) -> None:
        for key, lag in self._lags.items():
            slowest = RELATIONS[key].slowest
            lag.add(*RELATIONS[key].quantities(block, RATE), block["vehicle_speed"] >= slowest if slowest else None)
        for name, ends in self._ends.items():
            step = residue_of(name)
            ends.add(np.round(block[name][np.isfinite(block[name])] / step) * step)

    def found(self, units: Mapping[str, str] | None = None) -> tuple[Fact, ...]:
        """Defects of the input signals."""
        lags = {key: lag for key, each in self._lags.items() if (lag := each.found()) and lag.correlation > FOLLOWS}
        known = {key: lag for key, lag in lags.items() if lag.gain_correlation > CORRELATION}
        found: dict[str, Fact] = {}
        # Clipping looks like a wrong scale, and so may a delay: each signal is named for its most likely defect only.
        for each in (*self._clipped(units or {}), *self._late(lags), *self._scaled(known)):
            if not any(name in found for name in each.rests_on):
                found |= dict.fromkeys(each.rests_on, each)
        return tuple(dict.fromkeys(found.values()))

    def _late(self, lags: Mapping[str, Lag]) -> list[Fact]:
        """Delayed signals; where one seems early, the other one is late, since no sensor is early."""
        sides = {}
        for key, lag in lags.items():
            relation, margin = RELATIONS[key], CERTAIN * lag.deviation
            if lag.delay > relation.latest + margin:
                sides[key] = relation.second, relation.first
            elif lag.delay < relation.earliest - margin:
                sides[key] = relation.first, relation.second
        times_late = Counter(late for (late, *_), _ in sides.values())
        found: dict[str, Fact] = {}
        for key, ((late, *others), (beside, *_)) in sides.items():
            delay = abs(lags[key].delay - RELATIONS[key].usual)
            deviation = math.hypot(lags[key].deviation, RELATIONS[key].usual_deviation)
            sentence = f"{late} is late relative to {beside}, by {delay:.2f} ± {deviation:.2f} s"
            if others and times_late[late] == 1:
                sentence += f", or {' or '.join(others)} is wrong"
            else:
                others = []
            found.setdefault(late, defect((late, *others), sentence, f"{late} is late"))
        return list(found.values())

    def _scaled(self, lags: Mapping[str, Lag]) -> list[Fact]:
        found = []
        for key, lag in lags.items():
            relation = RELATIONS[key]
            if lag.gain > 0.0 and not 1.0 / relation.gain < lag.gain < relation.gain:
                names = (*relation.second, *relation.first)
                second, first = relation.words
                sentence = f"{' or '.join(names)} has a wrong scale: {second} is {lag.gain:.2f} times {first}"
                found.append(defect(names, sentence))
        return found

    def _clipped(self, units: Mapping[str, str]) -> list[Fact]:
        found = []
        least = max(SHORTEST_CLIPPED * RATE, SHARE_CLIPPED * self._samples)
        for name, ends in self._ends.items():
            for side, extreme, count, others in ends.ends():
                if extreme != 0.0 and count > least and piles_up(count, others):
                    value = in_words(extreme, units.get(name, ""), 4)
                    sentence = f"{name} is clipped at its {side} limit {value} for {count / RATE:.0f} s in total"
                    found.append(defect((name,), sentence, f"{name} is clipped"))
        return found


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
