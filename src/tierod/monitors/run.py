"""Run a monitor over a recording of any length, and put together what it found."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tierod import __version__
from tierod.decimation import Decimator
from tierod.derive import complete, ingredients
from tierod.errors import InputError, ParameterError, nearest
from tierod.findings import Diagnosis
from tierod.monitors.decided import decided
from tierod.monitors.named_vehicle import other_vehicle, vehicle_named_in
from tierod.monitors.over_time import OverTime
from tierod.monitors.own_level import OwnLevel, load_own_level, refuse_foreign, store_own_level
from tierod.monitors.pieces import CHUNK, OVERLAP, joined, pieces_of, refuse_leap, share_read
from tierod.monitors.quality_over_chunks import QualityOverChunks
from tierod.monitors.session import Conclusion, Monitor, Session, StatusChange, Variant
from tierod.monitors.suitable import refuse_unsuitable
from tierod.readers import SHARE_READ
from tierod.recording import Aligned, Recording
from tierod.vehicles import Vehicle, load
from tierod.writers import require_writable, write

if TYPE_CHECKING:
    from tierod.monitors.into_memory import MemoryFeed


def diagnose(
    source: Recording | str | Path,
    vehicle: Vehicle | str | Path | None = None,
    monitor: str | None = None,
    variant: str | None = None,
    *,
    dbc: Any = None,
    channel_map: Any = None,
    own_level: OwnLevel | str | Path | None = None,
    memory: str | Path | None = None,
    signals: str | Path | None = None,
    command: str = "",
    progress: Callable[[float], None] | None = None,
) -> Diagnosis:
    """What a monitor finds in a recording.

    Args:
        source: a recording, or the path of one; a file is read and judged piece by piece
        vehicle: parameter set, its name, or the path of its file; None takes the one that the recording names
        monitor: name of the monitor; that of the vehicle file where not given, and friction where it names none
        variant: name of the variant; the monitor's default where not given, if it has one
        dbc: path(s) of CAN databases; the vehicle's own where not given
        channel_map: path of a channel map; the vehicle's own where not given
        own_level: what was learnt of this vehicle from earlier recordings. A path of a file that does not exist yet is
            written where the vehicle is healthy; an existing one is never changed, lest a slow fault creep into it
        memory: path of a fault memory, which takes the recording as one operation cycle; written anew if there is none
        signals: path of a recording that takes what the monitor reads and tells over time, at its own rate: estimates,
            states, what replaces a sensor; .parquet, .csv or .mf4
        command: what the user typed, for the report
        progress: called with the share done, 0 to 1

    Raises:
        InputError: the recording cannot be read, or lacks what the monitor needs; or the own level is another vehicle's
        OutputError: the own level, the fault memory or the signals cannot be written
        ParameterError: no such vehicle, monitor or variant; none, and the recording names none; or no variant, and the
            monitor has no default
    """
    if signals is not None:
        require_writable(signals)
    if vehicle is None:
        vehicle = vehicle_named_in(source, dbc, channel_map)
    car = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    definition, chosen = find(monitor or usual_monitor(car), variant)
    known = own_level if isinstance(own_level, OwnLevel) else _stored(own_level)
    kept = None if signals is None else OverTime()
    run = Run(definition, chosen, car, known, memory, kept)
    for place, piece in enumerate(pieces_of(source, run.needs, car, dbc, channel_map)):
        if place == 0:
            suited, picked = _suited(definition, chosen if variant else None, piece)
            if (suited, picked) != (definition, None):
                run = Run(suited, picked or chosen, car, known, memory, kept)
        run.add(piece)
        if progress:
            progress(share_read(piece))
    diagnosis = run.finish(command)
    if signals is not None and kept is not None:
        units = {name: each.unit for name, each in diagnosis.traces.items()}
        write(kept.recording(units, f"tierod, monitor {run.monitor.name}"), signals)
    if isinstance(own_level, str | Path) and known is None and run.learnt:
        store_own_level(dataclasses.replace(run.learnt, learnt=diagnosis.created), own_level)
    return diagnosis


def _suited(definition: Monitor, asked: Variant | None, piece: Recording) -> tuple[Monitor, Variant | None]:
    """The monitor on the grid of a recording, and the variant other than the default that this has signals for."""
    picked = None
    if asked is None:
        picked = definition.variant_for(complete(piece, [*definition.required, *definition.optional]))
    if picked is None or picked.name == definition.default:
        return definition.suited_to(piece), None
    return definition.needing(picked).suited_to(piece), picked


def _stored(path: str | Path | None) -> OwnLevel | None:
    return load_own_level(path) if path is not None and Path(path).exists() else None


def usual_monitor(vehicle: Vehicle) -> str:
    """The monitor that judges a vehicle's recordings where nobody names one.

    Args:
        vehicle: whose file may name it
    """
    return vehicle.monitor or "friction"


def find(monitor: str, variant: str | None = None) -> tuple[Monitor, Variant]:
    """The monitor and variant of these names.

    Raises:
        ParameterError: there is none, and the message names the nearest; or none is given where the user must choose
    """
    from tierod.monitors.registry import MONITORS

    if monitor not in MONITORS:
        raise ParameterError(f"there is no monitor '{monitor}'{nearest(monitor, MONITORS)}")
    definition = MONITORS[monitor]
    if variant is None:
        variant = definition.default
    if variant is None:
        choices = " or ".join(f"'{each.name}' ({each.summary.rstrip('.')})" for each in definition.variants.values())
        raise ParameterError(
            f"the monitor '{monitor}' has no default variant, since the wrong one gives a wrong verdict; "
            f"choose with --variant (in Python: variant=...) {choices}"
        )
    if variant not in definition.variants:
        raise ParameterError(
            f"the monitor '{monitor}' has no variant '{variant}'{nearest(variant, definition.variants)}"
        )
    chosen = definition.variants[variant]
    return definition.needing(chosen), chosen


class Run:
    """One monitor over one recording, piece by piece; the result does not depend on how the recording is cut."""

    def __init__(
        self,
        monitor: Monitor,
        variant: Variant,
        vehicle: Vehicle,
        own_level: OwnLevel | None = None,
        memory: str | Path | None = None,
        kept: OverTime | None = None,
    ):
        self.monitor, self.variant, self.vehicle = monitor, variant, vehicle
        if own_level is not None:
            refuse_foreign(own_level, vehicle.name, f"{monitor.name}, {variant.name}")
        self.session: Session = _opened(monitor, variant, vehicle, own_level)
        self.feed = _feed(memory, vehicle, monitor) if memory else None
        self.kept = kept
        self.learnt: OwnLevel | None = None
        self.course: tuple[StatusChange, ...] = ()
        self.code_courses: Mapping[str, tuple[StatusChange, ...]] = {}
        self.needs = ingredients([*monitor.required, *monitor.optional])
        self._quality = QualityOverChunks(self.needs)
        self._before: Recording | None = None
        self._start: float | None = None
        self._steps = 0
        self._metadata: dict[str, Any] = {}
        units = dict.fromkeys(self.session.signals, "") | dict(self.session.traces)
        self._traces = {name: Decimator(name, unit) for name, unit in units.items()}

    def add(self, piece: Recording) -> None:
        """The next piece of the recording.

        Raises:
            InputError: the piece lacks a signal that the monitor needs, or brings it too slowly
        """
        begin, last = piece.span
        refuse_leap(begin if self._start is None else self._start + self._steps / self.monitor.rate, last)
        whole = complete(joined(self._before, piece), [*self.monitor.required, *self.monitor.optional])
        complete_piece = whole.slice(begin) if self._before else whole
        self._quality.add(complete_piece)
        self._metadata |= {k: v for k, v in piece.metadata.items() if k != SHARE_READ}
        if self._start is None:
            refuse_unsuitable(self.monitor, self.vehicle, complete_piece)
            self._quality.refuse_slow(self.monitor.required, self.monitor.minimum_rate)
            self._start = begin
        self._before = piece.slice(last - OVERLAP)
        while len((aligned := self._aligned(whole, last)).time):
            self._absorb(aligned)

    def _aligned(self, whole: Recording, last: float) -> Aligned:
        """What follows on what was judged already, no more than CHUNK of it: a gap of days must fit into memory."""
        assert self._start is not None
        start = self._start + self._steps / self.monitor.rate
        return whole.align(
            self.session.signals,
            self.monitor.rate,
            maximum_age=self.monitor.maximum_age,
            start=start,
            stop=min(last + 0.5 / self.monitor.rate, start + CHUNK),
        )

    def _absorb(self, aligned: Aligned) -> None:
        self._steps += len(aligned.time)
        shown = {**dict(zip(aligned.names, aligned.values.T, strict=True)), **self.session.absorb(aligned)}
        if self.feed:
            self.feed.add(aligned, self.monitor.rate)
        if self.kept:
            self.kept.add(aligned.time, shown)
        for name, values in shown.items():
            self._traces[name].add(aligned.time, values)

    def finish(self, command: str = "") -> Diagnosis:
        """The diagnosis over all pieces.

        Raises:
            InputError: there was no sample, or a signal that the monitor needs was constant or missing throughout
        """
        if not self._steps:
            raise InputError("the recording holds no samples; check that the file is whole and the channel map fits it")
        self._quality.refuse_unusable(self.monitor.required)
        conclusion = self.session.conclude()
        self.learnt, self.course = conclusion.own_level, conclusion.course
        self.code_courses = conclusion.code_courses
        units = self._quality.units
        traces = {name: each.trace() for name, each in self._traces.items() if name not in conclusion.withheld}
        for name in self.session.signals:
            if name in traces and name not in self.session.traces:
                traces[name] = dataclasses.replace(traces[name], unit=units.get(name, ""))
        other = other_vehicle(self._metadata, self.vehicle.name)
        finding = _with_warnings(
            conclusion,
            (
                *((other,) if other else ()),
                *self._metadata.get("warnings", ()),
                *self._quality.contradictions(),
                *self._quality.range_warnings(),
            ),
        )
        diagnosis = Diagnosis(
            findings=(finding,),
            elements=conclusion.elements,
            traces=traces,
            histograms=dict(conclusion.histograms),
            loops=dict(conclusion.loops),
            consistency=dict(conclusion.consistency),
            remarks=dict(conclusion.remarks),
            quality=self._quality.rows(),
            parameters=(*self.vehicle.rows(), *conclusion.parameters),
            decisions=decided(self.variant.decisions, self.session),
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
        if self.feed:
            self.feed.finish(diagnosis, self.course, self.code_courses)
        return diagnosis


def _feed(memory: str | Path, vehicle: Vehicle, monitor: Monitor) -> MemoryFeed:
    from tierod.monitors.into_memory import MemoryFeed  # few runs have a memory, and it takes its time to load

    return MemoryFeed(memory, vehicle.name, monitor.name)


def _opened(monitor: Monitor, variant: Variant, vehicle: Vehicle, own_level: OwnLevel | None) -> Session:
    try:
        return variant.open(vehicle, monitor.rate, own_level)
    except ParameterError as error:
        raise ParameterError(f"the monitor '{monitor.name}' cannot run as '{variant.name}': {error}") from None


def _with_warnings(conclusion: Conclusion, warnings: Iterable[str]) -> Any:
    finding = conclusion.finding
    return dataclasses.replace(finding, warnings=tuple(dict.fromkeys([*finding.warnings, *warnings])))
