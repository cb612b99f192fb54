"""Diagnosis of a recording of any length by one monitor, by several, or by all that can run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.findings import Diagnosis, Status
from tierod.core.recording import Channel, Recording
from tierod.monitors.acceptance import refusals, taken, vehicle_named_in
from tierod.monitors.baseline import Baseline, keep_first, load_baseline
from tierod.monitors.pieces import joined, pieces_of, share_read
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.monitors.runner import Chosen, Runner, find, read_by_any, usual
from tierod.monitors.session import Monitor, Variant
from tierod.vehicles import Vehicle, load


def diagnose(
    source: Recording | str | Path,
    vehicle: Vehicle | str | Path | None = None,
    monitor: str | Monitor | Variant | None = None,
    variant: str | Variant | None = None,
    *,
    dbc: Any = None,
    channel_map: Any = None,
    baseline: Baseline | str | Path | None = None,
    memory: str | Path | None = None,
    signals: str | Path | None = None,
    spread: bool = True,
    fault_free: bool = False,
    command: str = "",
    progress: Callable[[float], None] = lambda share: None,
) -> Diagnosis:
    """Diagnose a recording with a monitor.

    Args:
        source: a recording, or the path of one; a file is read and judged piece by piece
        vehicle: parameter set, its name, or the path of its file; None takes the one that the recording names
        monitor: name of a registered monitor, a monitor, or a variant of a registered one; None takes the monitor of
            the vehicle file, or friction where the file names none
        variant: name of the variant, or a variant; the monitor's default where not given, if it has one
        dbc: path(s) of CAN databases; the vehicle's own where not given
        channel_map: path of a channel map; the vehicle's own where not given
        baseline: baseline of this vehicle from earlier recordings, or the path of its file. A file that does not exist
            yet is written if the verdict is healthy; an existing file is never changed, so that a slow fault cannot
            become part of the baseline
        memory: path of a fault memory, which takes the recording as one operation cycle; created if it does not exist
        signals: path of a file (.parquet, .csv or .mf4) for the inputs and estimates of the monitor over time, at the
            rate of its grid, substitutes of sensors included
        spread: whether the spread of the vehicle's parameters is carried into bands and verdict, which takes up to six
            times the computing time
        fault_free: whether the vehicle is known to have been fault-free in the recording: a baseline is then learnt
            from it though guesses in the vehicle file forbid a verdict
        command: command line as typed by the user, for the report
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: the recording cannot be read, or lacks a signal that the monitor needs; or the baseline belongs to
            another vehicle or monitor
        OutputError: the baseline, the fault memory or the signals cannot be written
        ParameterError: no such vehicle, monitor or variant; no vehicle given, and the recording names none; or no
            variant given, and the monitor has no default
    """
    if signals is not None:
        from tierod.io.writers import require_writable, write  # few diagnoses write signals

        require_writable(signals)
    named = vehicle_named_in(source, dbc, channel_map) if vehicle is None else vehicle
    car = named if isinstance(named, Vehicle) else load(named)
    definition, chosen = find(monitor or usual_monitor(car), variant)
    known = baseline if isinstance(baseline, Baseline) else _stored(baseline)
    free, over_time = variant is None and not isinstance(monitor, Variant), OverTime()
    run = Run(
        definition, chosen, car, free=free, baseline=known, memory=memory, uncertain=spread,
        kept=None if signals is None else over_time.add,
    )  # fmt: skip
    for piece in pieces_of(source, run.needs, car, dbc, channel_map):
        run.add(piece)
        progress(share_read(piece))
    diagnosis = run.finish(command)
    if signals is not None:
        units = {name: each.unit for name, each in diagnosis.traces.items()}
        write(over_time.recording(units, f"tierod, monitor {run.monitor.name}"), signals)
    if isinstance(baseline, str | Path):
        diagnosis = diagnosis.remarked("baseline", _kept(run, baseline, known, diagnosis, fault_free))
    return diagnosis


class OverTime:
    """Collects signals piece by piece; one hour of 40 signals at 100 Hz takes 120 MB."""

    def __init__(self) -> None:
        self._pieces: list[tuple[np.ndarray, Mapping[str, np.ndarray]]] = []

    def add(self, time: np.ndarray, shown: Mapping[str, np.ndarray]) -> None:
        """Add time stamps [s] and signals by name of the next piece, (n,) each."""
        self._pieces.append((time, shown))

    @property
    def time(self) -> np.ndarray:
        """Time stamps of all pieces [s], (n,)."""
        return np.concatenate([time for time, _ in self._pieces])

    def values(self, name: str) -> np.ndarray:
        """One signal over all pieces, (n,)."""
        return np.concatenate([np.asarray(shown[name], float) for _, shown in self._pieces])

    def recording(self, units: Mapping[str, str], source: str) -> Recording:
        """All pieces as one recording of the signals that have a unit, on the grid of the monitor."""
        time = self.time
        return Recording({name: Channel(name, time, self.values(name), unit, source) for name, unit in units.items()})


def _kept(run: Run, path: str | Path, known: Baseline | None, diagnosis: Diagnosis, fault_free: bool) -> str:
    """Write the baseline file after the first fault-free recording; what became of it, in a sentence."""
    if known is not None:
        return f"judged against {path}, learnt {known.learnt or 'at a time unknown'}; the file stays as it is"
    learnt = run.learnt or (run.unproven if fault_free else None)
    if learnt is not None:
        return keep_first(dataclasses.replace(learnt, learnt=diagnosis.created), path)
    status = diagnosis.findings[0].status
    if not run.monitor.learns:
        reason = f"the monitor '{run.monitor.name}' learns no baseline"
    elif status is not Status.HEALTHY:
        reason = f"the verdict is '{status}', and a baseline is learnt from a healthy recording only"
        if run.unproven is not None:
            reason += "; if you know that the car was fault-free in this recording, add --fault-free"
    else:
        reason = "too little of the recording could be judged to learn one"
    return f"{path} was not written: {reason}"


def _stored(path: str | Path | None) -> Baseline | None:
    return load_baseline(path) if path is not None and Path(path).exists() else None


def usual_monitor(vehicle: Vehicle) -> str:
    """Name of the monitor for a vehicle's recordings where the user names none."""
    return vehicle.monitor or "friction"


ALL = "all"  # Name that stands for all monitors that can run

SLICE = 600.0  # Duration of a recording that is read at once while a stretch is being located [s]


class NotRun(NamedTuple):
    """A monitor that did not judge a recording, and why."""

    monitor: str
    reason: str


@dataclass(frozen=True)
class Judged:
    """Findings of the monitors in one recording."""

    path: Path  # path of the recording
    vehicle: str  # name of the vehicle whose parameters were used
    diagnoses: dict[str, Diagnosis]  # diagnoses by the name of the monitor
    not_run: tuple[NotRun, ...] = ()  # monitors that did not judge the recording


def judge(
    path: Path,
    car: Vehicle,
    monitors: Sequence[str] | None = None,
    *,
    dbc: Any = None,
    channel_map: Any = None,
    start: float | None = None,
    stop: float | None = None,
    spread: bool = True,
    command: str = "",
    progress: Callable[[float], None] = lambda share: None,
) -> Judged:
    """Judge a recording with several monitors, or with all that can run.

    Args:
        monitors: names of monitors; None takes all that can run and have a default variant
        dbc, channel_map: see `diagnose`
        start, stop: bounds of the stretch to be judged, in the time of the recording [s]; None is no bound
        spread: see `diagnose`
        command: command line as typed by the user, for the report
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: the recording cannot be read, or the stretch is empty
        ParameterError: no such monitor
    """
    source = source_of(path, car, dbc, channel_map, start, stop)
    for name in monitors or ():
        MONITORS.required(name)
    runner = Runner(car, None if monitors is None else [Chosen(name) for name in monitors], spread)
    try:
        for piece in pieces_of(source, runner.needs, car, dbc, channel_map):
            runner.add(piece)
            progress(share_read(piece))
    except InputError as error:
        if runner.span is None:
            raise
        runner.refuse_all(str(error))
    found = {name: each.diagnosis for name, each in runner.concluded(command)}
    names = tuple(MONITORS) if monitors is None else tuple(monitors)
    missed = (NotRun(name, runner.refused[name]) for name in names if name in runner.refused)
    return Judged(path, car.name, found, tuple(missed))


def not_judged(path: Path, car: Vehicle, monitors: Sequence[str] | None, reason: str) -> Judged:
    """Result for a recording that no monitor could judge.

    Args:
        monitors: names of the monitors; None stands for all
    """
    names = tuple(MONITORS) if monitors is None else tuple(monitors)
    return Judged(path, car.name, {}, tuple(NotRun(name, reason) for name in names))


def source_of(
    path: Path,
    car: Vehicle,
    dbc: Any,
    channel_map: Any,
    start: float | None,
    stop: float | None,
    names: Iterable[str] | None = None,
) -> Path | Recording:
    """Path of a recording, or the stretch of it between `start` and `stop`, read into memory.

    Args:
        names: signals to be read; None reads all
    """
    if start is None and stop is None:
        return path
    first, last = float("-inf") if start is None else start, float("inf") if stop is None else stop
    if not first < last:
        raise InputError(f"a stretch from {first:g} to {last:g} s is empty; give --from before --to")
    whole, seen = None, (float("inf"), float("-inf"))
    for piece in pieces_of(path, names, car, dbc, channel_map, SLICE):
        seen = (min(seen[0], piece.span[0]), max(seen[1], piece.span[1]))
        part = piece.slice(first, last)
        if any(len(channel.time) for channel in part.channels.values()):
            whole = joined(whole, part)
        if piece.span[0] >= last:
            break
    if whole is None:
        where = f"from {first:g} s on" if stop is None else f"between {first:g} and {last:g} s"
        where = f"before {last:g} s" if start is None else where
        raise InputError(f"{path} has no data {where}; it covers {seen[0]:.6g} to {seen[1]:.6g} s")
    return whole


def able(source: Path | Recording, car: Vehicle, dbc: Any = None, channel_map: Any = None) -> Iterator[str]:
    """Names of the usual monitors that would accept a recording, determined from its first piece."""
    if isinstance(source, Path) and source.is_fifo():
        return
    piece = next(iter(pieces_of(source, read_by_any(), car, dbc, channel_map)))
    # A monitor without required signals has to be run on a sample of the recording: check the fast ones first.
    for each in sorted((MONITORS[chosen.monitor] for chosen in usual()), key=lambda each: not each.required):
        if taken(each, refusals(each, car, piece)):
            yield each.name
