"""Run of one monitor over one recording, piece by piece, with its diagnosis at the end."""

from __future__ import annotations

import dataclasses
import datetime
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from tierod.core.decimation import Decimator, bins_each
from tierod.core.errors import InputError
from tierod.core.facts import Fact, defect
from tierod.core.findings import Diagnosis, Finding, ParameterEffect, Status, Trace
from tierod.core.recording import Aligned, Recording
from tierod.core.version import __version__
from tierod.io.derive import complete, ingredients
from tierod.io.readers import SHARE_READ
from tierod.methods.relations import witnesses
from tierod.monitors.acceptance import refuse_unsuitable
from tierod.monitors.baseline import Baseline, refuse_foreign
from tierod.monitors.decision import Passing, decided
from tierod.monitors.inputs import InputChecks
from tierod.monitors.pieces import CHUNK, OVERLAP, Shared, Silence, joined, together
from tierod.monitors.robustness import exact, robust
from tierod.monitors.session import (
    BlockSession,
    Conclusion,
    Monitor,
    Session,
    StatusChange,
    SubjectsSession,
    Variant,
    opened,
)
from tierod.monitors.uncertainty import Lanes, Uncertain
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import in_words

if TYPE_CHECKING:
    from tierod.monitors.memory import MemoryFeed, SampleDigest


SETTLING = 2.0
"""Shortest beginning of a recording that decides on grid and variant [s]: some samples of the slowest message."""

LEAST_STEPS = 3
"""Grid steps of a beginning beyond the listening time of its session, since steps at its edges are judged later."""

ROUNDING = 1e-6
"""Time after a step of the grid within which a sample still belongs to it, as in the alignment of recordings [s]."""


Kept: TypeAlias = Callable[[np.ndarray, Mapping[str, np.ndarray]], None]
"""Receives the time stamps [s] of a piece, and inputs and estimates by name, (n,) each."""

EXACT = "all parameters of the vehicle are assumed to be exact: bands and verdict do not include their spread"
"""Remark of a diagnosis without the spread of the parameters."""


class Ended(NamedTuple):
    """Conclusion of a monitor, with the effects of the parameters, before it is compared with that of others."""

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

    The session opens as soon as the beginning of the recording shows its sampling rates and signals.

    Args:
        monitor: monitor to be run, with the required signals of the variant
        free: whether the first variant runs whose signals the recording has, if the given one lacks some
        baseline: baseline of this vehicle; None lets the monitor learn one
        memory: path of the fault memory that takes the recording as one operation cycle
        kept: receives time stamps [s], inputs and estimates of every piece, as it is judged
        uncertain: whether the spread of the vehicle's parameters is carried into bands and verdict
        bins: least number of bins of every trace, allocated at once; None takes as many as memory allows
        signals_shown: whether the diagnosis includes what only a report shows, beside the estimates: histograms, loops
            and the input signals over time

    `needs` are the channels to be read, `is_open` is whether grid and variant are known, and `beginning` is the part of
    the recording that waits for that; None where none does.
    """

    session: Session  # Session of the monitor, from the first piece on that shows its grid

    def __init__(
        self,
        monitor: Monitor,
        variant: Variant,
        vehicle: Vehicle,
        *,
        free: bool = False,
        baseline: Baseline | None = None,
        memory: str | Path | None = None,
        kept: Kept | None = None,
        uncertain: bool = False,
        bins: int | None = None,
        signals_shown: bool = True,
    ):
        self.monitor, self.variant, self.vehicle, self.kept = monitor, variant, vehicle, kept
        self.needs = channels_of(monitor)
        self._free, self._baseline, self._spread = free, baseline, uncertain
        self._bins, self._signals_shown = bins, signals_shown
        self.is_open = False
        self.beginning: Recording | None = None
        self._uncertain: Uncertain | None = None
        self._lanes: Lanes | None = None
        self.feed: MemoryFeed | None = None
        self._digest: SampleDigest | None = None
        if memory:
            from tierod.monitors import memory as cycles  # slow to import, and few runs have a memory

            self.feed = cycles.MemoryFeed(memory, vehicle.name, monitor.name)
            self._digest = cycles.SampleDigest(cycles.read_by_all(monitor))
        self.learnt: Baseline | None = None
        self.unproven: Baseline | None = None
        self.course: tuple[StatusChange, ...] = ()
        self.code_courses: Mapping[str, tuple[StatusChange, ...]] = {}
        self._before: Recording | None = None
        self._start: float | None = None
        self._steps = 0
        self._silence = Silence()
        self._metadata: dict[str, Any] = {}

    @property
    def begun(self) -> bool:
        """Whether at least one step of the grid was judged."""
        return self._steps > 0

    @property
    def waits(self) -> str:
        """Why nothing is judged yet, in words; "" once it judges."""
        if not self.is_open:
            return "no frame came yet"
        return "" if self.beginning is None else f"listens for {self._listening:.0f} s before it judges"

    @property
    def _listening(self) -> float:
        return float(getattr(self.session, "listens", 0.0))

    def add(self, piece: Recording, shared: Shared | None = None) -> None:
        """Add the next piece; `shared` holds its qualities, for all monitors that have received the same pieces."""
        if self._start is None:
            shared = shared if self.beginning is None else None
            # Another variant may begin with what this one refuses.
            piece = self.beginning = joined(self.beginning, piece)
            seconds = piece.span[1] - piece.span[0]
            if seconds >= SETTLING and not self.is_open:
                self._open(piece)
            if not self.is_open or seconds < self._listening + LEAST_STEPS / self.monitor.rate:
                return
        self._add(piece, shared)
        self.beginning = None

    def settle(self) -> None:
        """Judge the beginning of a recording that has ended before it was long enough to decide on the grid."""
        first, self.beginning = self.beginning, None
        if first is not None:
            if not self.is_open:
                self._open(first)
            self._add(first)

    def _open(self, first: Recording) -> None:
        """Open the session on the grid, and with the variant, that suit the beginning of a recording."""
        monitor, variant = self.monitor, self.variant
        picked = monitor.variant_for(complete(first, _signals(monitor))) if self._free else None
        if picked is not None and picked.name != monitor.default:
            monitor, variant = monitor.needing(picked), picked
        whole = complete(first, _signals(monitor))
        refuse_unsuitable(monitor, self.vehicle, whole)
        monitor = monitor.suited_to(whole)
        if self._baseline is not None:
            refuse_foreign(self._baseline, self.vehicle.name, f"{monitor.name}, {variant.name}")
        self._uncertain = Uncertain(monitor, variant, self.vehicle, self._baseline) if self._spread else None
        session = self._uncertain.session if self._uncertain else opened(monitor, variant, self.vehicle, self._baseline)
        if isinstance(session, BlockSession):
            session.pictured = self._signals_shown
        self._inputs, self._passing = InputChecks(monitor, session.signals), Passing(variant.decisions, session)
        units = dict.fromkeys(session.signals, "") | dict(session.traces)
        room = bins_each(len(units)) if self._bins is None else self._bins
        over_time = units if self._signals_shown else session.traces
        self._traces = {name: Decimator(name, units[name], room, self._bins is not None) for name in over_time}
        self.monitor, self.variant, self.session, self.is_open = monitor, variant, session, True

    def _add(self, piece: Recording, shared: Shared | None = None) -> None:
        begin, last = piece.span
        shared = shared or Shared(self._before, piece)
        # Signals are derived over the end of the previous piece too, so that no cut affects them; the quality counts
        # each sample once.
        whole = complete(shared.whole, _signals(self.monitor))
        complete_piece = shared.with_channels_of_piece(whole.slice(begin)) if self._before else whole
        self._inputs.quality.add(complete_piece, shared.qualities)
        if self._digest:
            self._digest.add(piece)
        self._metadata |= {k: v for k, v in piece.metadata.items() if k != SHARE_READ}
        if self._start is None:
            self._start = begin
            self._lanes = self._uncertain.lanes() if self._uncertain else None
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
            self.kept(aligned.time, shown)
        self._passing.add(aligned.time, shown)
        places = None
        for name, trace in self._traces.items():
            places = trace.add(aligned.time, shown[name], places)

    def conclude(self) -> Ended:
        """Conclusion over all pieces, before it is compared with that of other monitors."""
        self.settle()
        if self._before is None or not self._steps:
            raise InputError("the recording holds no samples; check that the file is whole and the channel map fits it")
        last = self._before.span[1]
        whole = complete(self._before, _signals(self.monitor))
        # The last steps, which `add` has held back for a next piece.
        self._judge(whole, last, last + 0.5 / self.monitor.rate)
        self._inputs.quality.refuse_unusable(self.monitor.required, self.monitor.minimum_rate)
        return Ended(self.monitor.name, *self._concluded())

    def finish(self, command: str = "", others: Sequence[Ended] = (), own: Ended | None = None) -> Diagnosis:
        """Diagnosis over all pieces; `own` is the result of `conclude`, where it is known."""
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
        conclusion, may_turn = self.session.conclude(), self._baseline is None
        if self._uncertain is None:
            return exact(conclusion, self.vehicle, may_turn, self.monitor.learns), ()
        effects = None if self._lanes is None else self._lanes.conclude(conclusion.verdict.estimate)
        found = robust(conclusion, effects, self._uncertain.vehicle, may_turn, self.monitor.learns)
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


def channels_of(monitor: Monitor) -> tuple[str, ...]:
    """Channels that a monitor reads, with those that reveal a stuck signal."""
    names = _signals(monitor)
    return tuple(dict.fromkeys((*ingredients(names), *witnesses(names))))


def _signals(monitor: Monitor) -> tuple[str, ...]:
    return (*monitor.required, *monitor.optional)
