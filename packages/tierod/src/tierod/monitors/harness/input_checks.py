"""Checks of a monitor's input signals over a recording: quality, stuck values, defects, missing stretches."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from tierod.core.facts import GUESSES, LONGEST_REASON, REPAIR, Fact, assemble, weigh
from tierod.core.findings import Finding
from tierod.core.recording import Aligned, Recording
from tierod.io.derive import ingredients
from tierod.monitors.harness.input_defects import InputDefects
from tierod.monitors.harness.named_vehicle import other_vehicle
from tierod.monitors.harness.presence import JudgedTime, MissingStretches
from tierod.monitors.harness.quality_over_chunks import QualityOverChunks
from tierod.monitors.harness.session import Conclusion, Monitor, StatusChange
from tierod.monitors.harness.stuck_over_drive import StuckOverDrive


class InputChecks:
    """Checks the input signals piece by piece beside the monitor, and states the facts about them.

    Args:
        monitor: monitor on the grid of the recording
        signals: input signals of its session

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
        """Refuse required signals with a low sampling rate; checks with every piece until all rates are known.

        Raises:
            InputError: a signal comes at less than the minimum rate of the monitor
        """
        if not self._paced:
            self._paced = self.quality.refuse_slow(self.monitor.required, self.monitor.minimum_rate)

    def add(self, whole: Recording, start: float, usable: Aligned) -> None:
        """Add the next samples.

        Args:
            whole: piece that the samples come from
            start: start of the recording [s]
            usable: input of the monitor, NaN where a signal is stuck
        """
        self._there.update(name for name in usable.names if name in whole)
        self.judged.add(usable, self._there)
        self.missing.add(usable)
        self.defects.add(whole, start, float(usable.time[-1]), self.stuck.spans())

    def found(
        self, conclusion: Conclusion, metadata: Mapping[str, Any], judged_as: str, others: Sequence[Fact] = ()
    ) -> tuple[Finding, Conclusion]:
        """Finding of a conclusion among the facts about its signals, and the conclusion that still holds then.

        Args:
            conclusion: conclusion of the session
            metadata: metadata of the recording
            judged_as: name of the vehicle whose parameters are used
            others: faults of sensors that other monitors declare
        """
        monitor, verdict = self.monitor, conclusion.verdict
        needed = {*monitor.required, *monitor.rests_on}
        lost = self.judged.lost(monitor.reaction, self.stuck.lasting())
        before = (
            *self.defects.found(self.quality.units),
            *(each for each in others if needed.intersection(each.rests_on)),
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
        unchanged = all(each.name == GUESSES for each in weigh(verdict, limiting, needed).lowering)
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
