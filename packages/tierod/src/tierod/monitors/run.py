"""Run of one monitor over one recording, piece by piece, with its diagnosis at the end."""

from __future__ import annotations

import dataclasses
import datetime
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tierod.core.decimation import Decimator, bins_each
from tierod.core.errors import InputError
from tierod.core.facts import Fact, defect
from tierod.core.findings import Diagnosis, Finding, ParameterEffect, Status, Trace
from tierod.core.recording import Aligned, Recording
from tierod.core.version import __version__
from tierod.io.derive import complete, ingredients
from tierod.io.readers import SHARE_READ
from tierod.monitors.harness.acceptance import refuse_unsuitable
from tierod.monitors.harness.baseline import Baseline, refuse_foreign
from tierod.monitors.harness.decision import Passing, decided
from tierod.monitors.harness.inputs import InputChecks
from tierod.monitors.harness.memory import SampleDigest
from tierod.monitors.harness.over_time import OverTime
from tierod.monitors.harness.pieces import CHUNK, OVERLAP, Silence, together
from tierod.monitors.harness.quality_over_chunks import Shared
from tierod.monitors.harness.session import (
    BlockSession,
    Conclusion,
    Monitor,
    Session,
    StatusChange,
    SubjectsSession,
    Variant,
    opened,
)
from tierod.monitors.robustness import exact, robust
from tierod.monitors.uncertainty import Lanes, Uncertain
from tierod.vehicles import Vehicle
from tierod.vehicles.uncertain import in_words

if TYPE_CHECKING:
    from tierod.monitors.harness.memory import MemoryFeed


def fitting(monitor: Monitor, variant: Variant, piece: Recording, asked: bool) -> tuple[Monitor, Variant]:
    """Monitor on the grid that suits a recording, and the variant whose signals the recording has.

    Args:
        monitor: monitor with the required signals of the variant
        variant: default variant, or the choice of the user
        piece: first piece of the recording
        asked: whether the user chose the variant, which is then kept
    """
    picked = None if asked else monitor.variant_for(complete(piece, [*monitor.required, *monitor.optional]))
    if picked is None or picked.name == monitor.default:
        return monitor.suited_to(piece), variant
    return monitor.needing(picked).suited_to(piece), picked


ROUNDING = 1e-6
"""Time after a step of the grid within which a sample still belongs to it, as in the alignment of recordings [s]."""


EXACT = "all parameters of the vehicle are assumed to be exact: bands and verdict do not include their spread"
"""Remark of a diagnosis without the spread of the parameters."""


class Ended(NamedTuple):
    """Conclusion of a monitor on a recording, before it is compared with that of other monitors.

    Args:
        monitor: name of the monitor
        conclusion: conclusion of its session with the spread of the parameters
        effects: effects of the parameters on it
    """

    monitor: str
    conclusion: Conclusion
    effects: tuple[ParameterEffect, ...]

    def faults(self) -> tuple[Fact, ...]:
        """Sensors that the monitor declares faulty, for monitors whose verdicts rest on them."""
        return tuple(
            defect((each.name,), f"{each.name} is faulty from {each.episodes[0].start:.1f} s on ({self.monitor})")
            for each in self.conclusion.elements
            if each.role == "sensor" and each.status is Status.FAULT and each.episodes
        )


class Run:
    """Run of one monitor over one recording; the result does not depend on how the recording is cut into pieces.

    Args:
        monitor: monitor to be run
        variant: variant of the monitor
        vehicle: vehicle whose parameters are used
        baseline: baseline of this vehicle; None lets the monitor learn one
        memory: path of the fault memory that takes the recording as one operation cycle
        kept: collects inputs and estimates over time
        uncertain: whether the spread of the vehicle's parameters is carried into bands and verdict
        bins: least number of bins of every trace, allocated at once; None takes as many as memory allows
        signals_shown: whether the diagnosis includes what only a report shows, beside the estimates: histograms, loops
            and the input signals over time

    Raises:
        InputError: the baseline belongs to another vehicle or variant
        ParameterError: the variant cannot run with this vehicle
    """

    def __init__(
        self,
        monitor: Monitor,
        variant: Variant,
        vehicle: Vehicle,
        baseline: Baseline | None = None,
        memory: str | Path | None = None,
        kept: OverTime | None = None,
        uncertain: bool = False,
        bins: int | None = None,
        signals_shown: bool = True,
    ):
        self.monitor, self.variant, self.vehicle = monitor, variant, vehicle
        self._given = (baseline, memory, kept, uncertain, bins, signals_shown)
        if baseline is not None:
            refuse_foreign(baseline, vehicle.name, f"{monitor.name}, {variant.name}")
        self._uncertain = Uncertain(monitor, variant, vehicle, baseline) if uncertain else None
        self.session: Session = (
            opened(monitor, variant, vehicle, baseline) if self._uncertain is None else self._uncertain.session
        )
        if isinstance(self.session, BlockSession):
            self.session.pictured = signals_shown
        self._lanes: Lanes | None = None
        self._may_turn = baseline is None
        self.feed: MemoryFeed | None = None
        if memory:
            from tierod.monitors.harness.memory import MemoryFeed  # slow to import, and few runs have a memory

            self.feed = MemoryFeed(memory, vehicle.name, monitor.name)
        self._digest = SampleDigest(_common(monitor)) if memory else None
        self.kept = kept
        self.learnt: Baseline | None = None
        self.unproven: Baseline | None = None
        self.course: tuple[StatusChange, ...] = ()
        self.code_courses: Mapping[str, tuple[StatusChange, ...]] = {}
        self._inputs = InputChecks(monitor, self.session.signals)
        self.needs = self._inputs.needs
        self._passing = Passing(variant.decisions, self.session)
        self._before: Recording | None = None
        self._start: float | None = None
        self._steps = 0
        self._silence = Silence()
        self._metadata: dict[str, Any] = {}
        units = dict.fromkeys(self.session.signals, "") | dict(self.session.traces)
        room = bins_each(len(units)) if bins is None else bins
        kept_over_time = units if signals_shown else dict(self.session.traces)
        self._traces = {name: Decimator(name, unit, room, bins is not None) for name, unit in kept_over_time.items()}

    @property
    def begun(self) -> bool:
        """Whether at least one step of the grid was judged."""
        return self._steps > 0

    def fitted(self, piece: Recording, asked: bool) -> Run:
        """Run on the grid and with the variant that suit a recording; see `fitting`.

        Args:
            piece: first piece of the recording
            asked: whether the user chose the variant, which is then kept
        """
        suited, picked = fitting(self.monitor, self.variant, piece, asked)
        if (suited, picked) == (self.monitor, self.variant):
            return self
        return Run(suited, picked, self.vehicle, *self._given)

    def add(self, piece: Recording, shared: Shared | None = None) -> None:
        """Add the next piece of the recording.

        Args:
            piece: next piece
            shared: piece with cached qualities, shared with monitors that have received the same pieces

        Raises:
            InputError: a required signal is missing, or its sampling rate is too low
        """
        begin, last = piece.span
        shared = shared or Shared(self._before, piece)
        # Signals are derived over the end of the previous piece too, so that no cut affects them; the quality counts
        # each sample once.
        whole = complete(shared.whole, [*self.monitor.required, *self.monitor.optional])
        complete_piece = shared.with_channels_of_piece(whole.slice(begin)) if self._before else whole
        self._inputs.quality.add(complete_piece, shared.qualities)
        if self._digest:
            self._digest.add(piece)
        self._metadata |= {k: v for k, v in piece.metadata.items() if k != SHARE_READ}
        if self._start is None:
            refuse_unsuitable(self.monitor, self.vehicle, complete_piece)
            self._start = begin
            self._lanes = None if self._uncertain is None else self._uncertain.lanes()
        self._inputs.refuse_slow()
        self._before = piece.slice(last - OVERLAP)
        # Later steps have to wait, since the next piece may hold samples that belong to them.
        self._judge(whole, begin, last - ROUNDING)

    def _judge(self, whole: Recording, begin: float, stop: float) -> None:
        """Judge the samples that follow those judged already, up to a time."""
        waiting: list[tuple[Aligned, Aligned]] = []
        count = 0
        for aligned in self._grid(whole, begin, stop):
            # Every call of a session costs some milliseconds: the stretches between pauses are absorbed together.
            count += len(aligned.time)
            if count > CHUNK * self.monitor.rate:
                self._absorb(waiting, whole)
                waiting, count = [], len(aligned.time)
            waiting.append((aligned, self._inputs.stuck.without(aligned, whole)))
        self._absorb(waiting, whole)

    def _grid(self, whole: Recording, begin: float, stop: float) -> Iterator[Aligned]:
        """Samples of a piece to be judged, on the grid of the monitor, in the order of time."""
        assert self._start is not None
        stamps = [whole[name].time for name in self.session.signals if name in whole]
        for skip_to, end in self._silence.stretches(stamps, begin, stop):
            self._steps = max(self._steps, math.floor((skip_to - self._start) * self.monitor.rate))
            while len((aligned := self._aligned(whole, end)).time):
                if not self._steps:
                    self.session.refuse(aligned)
                self._steps += len(aligned.time)
                yield aligned

    def _aligned(self, whole: Recording, stop: float) -> Aligned:
        """Samples that follow those judged already, CHUNK seconds at most, so that a long piece fits into memory."""
        assert self._start is not None
        start = self._start + self._steps / self.monitor.rate
        return whole.align(
            self.session.signals,
            self.monitor.rate,
            maximum_age=self.monitor.maximum_age,
            start=start,
            stop=min(stop, start + CHUNK),
        )

    def _absorb(self, parts: Sequence[tuple[Aligned, Aligned]], whole: Recording) -> None:
        """Absorb (recorded, usable) samples; in the usable ones stuck signals are NaN."""
        if not parts:
            return
        aligned, usable = (together(each) for each in zip(*parts, strict=True))
        assert self._start is not None
        self._inputs.add(whole, self._start, usable)
        # Reports show stuck signals as recorded; only the input of the monitor is without them.
        traces = self.session.absorb(usable)
        if self._lanes is not None:
            traces = self._lanes.absorb(usable, traces)
        if isinstance(self.session, BlockSession):
            self.session.observe(traces)
        shown = {**aligned.columns, **traces}
        if self.feed:
            self.feed.add(aligned, self.monitor.rate)
        if self.kept:
            self.kept.add(aligned.time, shown)
        self._passing.add(aligned.time, shown)
        places = None
        for name, trace in self._traces.items():
            places = trace.add(aligned.time, shown[name], places)

    def conclude(self) -> Ended:
        """Conclusion over all pieces, before it is compared with that of other monitors.

        Raises:
            InputError: there was no sample, or a required signal was constant or missing throughout
        """
        if self._before is None or not self._steps:
            raise InputError("the recording holds no samples; check that the file is whole and the channel map fits it")
        last = self._before.span[1]
        whole = complete(self._before, [*self.monitor.required, *self.monitor.optional])
        # The last steps, which `add` has held back for a next piece.
        self._judge(whole, last, last + 0.5 / self.monitor.rate)
        self._inputs.quality.refuse_unusable(self.monitor.required, self.monitor.minimum_rate)
        return Ended(self.monitor.name, *self._concluded())

    def finish(self, command: str = "", others: Sequence[Ended] = (), own: Ended | None = None) -> Diagnosis:
        """Diagnosis over all pieces.

        Args:
            command: command line as typed by the user, for the report
            others: conclusions of other monitors on the same recording
            own: result of `conclude`, where it is known

        Raises:
            InputError: there was no sample, or a required signal was constant or missing throughout
        """
        _, concluded, effects = own or self.conclude()
        faults = [each for one in others for each in one.faults()]
        finding, conclusion = self._inputs.found(concluded, self._metadata, self.vehicle.name, faults)
        self.learnt, self.course = conclusion.baseline, conclusion.course
        self.unproven = conclusion.unproven if self._uncertain is not None else None
        self.code_courses = conclusion.code_courses
        diagnosis = dataclasses.replace(self._diagnosis(finding, conclusion, command), parameter_effects=effects)
        if self._uncertain is None:
            diagnosis = diagnosis.remarked("parameters", EXACT)
        if self.feed and self._digest:
            taken = self.feed.finish(diagnosis, self.course, self.code_courses, self._digest.result())
            diagnosis = diagnosis.remarked("fault memory", taken)
        return diagnosis

    def _concluded(self) -> tuple[Conclusion, tuple[ParameterEffect, ...]]:
        """Conclusion of the session including the spread of the parameters, and the effects of the parameters on it."""
        if isinstance(self.session, SubjectsSession):
            self.session.stuck = self._inputs.stuck.spans()
        conclusion = self.session.conclude()
        if self._uncertain is None:
            return exact(conclusion, self.vehicle, self._may_turn, self.monitor.learns), ()
        effects = None if self._lanes is None else self._lanes.conclude()
        found = robust(conclusion, effects, self._uncertain.vehicle, self._may_turn, self.monitor.learns)
        note = in_words(self._uncertain.vehicle, self._uncertain.of_class)
        remarks = {**found.conclusion.remarks, **({"parameters": f"{note}."} if note else {})}
        return dataclasses.replace(found.conclusion, remarks=remarks), found.effects

    def _diagnosis(self, finding: Finding, conclusion: Conclusion, command: str) -> Diagnosis:
        return Diagnosis(
            findings=(finding,),
            elements=conclusion.elements,
            traces=self._shown(conclusion.withheld),
            histograms=dict(conclusion.histograms),
            loops=dict(conclusion.loops),
            consistency=dict(conclusion.consistency),
            remarks=dict(conclusion.remarks),
            quality=self._inputs.quality.rows(),
            parameters=(*self.vehicle.rows(), *conclusion.parameters),
            decisions=decided(
                self.variant.decisions,
                self.session,
                {**self._passing.reached, **conclusion.distances},
                self._passing.passed,
            ),
            recording=self._metadata | {"duration_s": self._steps / self.monitor.rate, "start_s": self._start},
            vehicle={
                "name": self.vehicle.name,
                "description": self.vehicle.description,
                "source": self.vehicle.source,
                "not_good_for": list(self.vehicle.not_good_for),
                "torque_unit": self.vehicle.torque_unit,
            },
            version=__version__,
            command=command,
            created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        )

    def _shown(self, withheld: Collection[str]) -> dict[str, Trace]:
        """Traces for the report, those of input signals in the units of the recording."""
        traces = {name: each.trace() for name, each in self._traces.items() if name not in withheld}
        units = self._inputs.quality.units
        for name in self.session.signals:
            if name in traces and name not in self.session.traces:
                traces[name] = dataclasses.replace(traces[name], unit=units.get(name, ""))
        return traces


def _common(monitor: Monitor) -> set[str]:
    """Channels that all own variants read, so that the fingerprint of a recording depends on no variant or package."""
    names = getattr(monitor.variants, "own", monitor.variants)
    own = [monitor, *(monitor.needing(monitor.variants[each]) for each in names)]
    return set.intersection(*(set(ingredients([*each.required, *each.optional])) for each in own))
