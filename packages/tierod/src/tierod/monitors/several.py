"""Findings of several monitors, or of all that can run, in one recording or a stretch of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.errors import InputError
from tierod.core.findings import Diagnosis
from tierod.core.recording import Recording
from tierod.monitors.every import Every, Look, read_by_any
from tierod.monitors.harness.acceptance import refusals, taken
from tierod.monitors.harness.pieces import joined, pieces_of, share_read
from tierod.monitors.registry import MONITORS
from tierod.monitors.together import Chosen, Together, usual
from tierod.vehicles import Vehicle

ALL = "all"
"""Name that stands for all monitors that can run."""

SLICE = 600.0
"""Duration of a recording that is read at once while a stretch is being located [s]."""


class NotRun(NamedTuple):
    """A monitor that did not judge a recording, and why."""

    monitor: str
    reason: str


@dataclass(frozen=True)
class Judged:
    """Findings of the monitors in one recording.

    Args:
        path: path of the recording
        vehicle: name of the vehicle whose parameters were used
        diagnoses: diagnoses by the name of the monitor
        not_run: monitors that did not judge the recording
    """

    path: Path
    vehicle: str
    diagnoses: dict[str, Diagnosis]
    not_run: tuple[NotRun, ...] = ()


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
        path: path of the recording
        car: vehicle whose parameters are used
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
    watching: Every | Together
    if monitors is None:
        watching = Every(car, look_at(source, car, dbc, channel_map), spread)
    else:
        for name in monitors:
            MONITORS.required(name)
        require_readable(source, car, dbc, channel_map)
        watching = Together(car, [Chosen(name) for name in monitors], spread)
    try:
        for piece in pieces_of(source, watching.needs, car, dbc, channel_map):
            watching.add(piece)
            progress(share_read(piece))
    except InputError as error:
        watching.refuse_all(str(error))
    found = {name: each.diagnosis for name, each in watching.concluded(command)}
    names = tuple(MONITORS) if monitors is None else tuple(monitors)
    missed = (NotRun(name, watching.refused[name]) for name in names if name in watching.refused)
    return Judged(path, car.name, found, tuple(missed))


def not_judged(path: Path, car: Vehicle, monitors: Sequence[str] | None, reason: str) -> Judged:
    """Result for a recording that no monitor could judge.

    Args:
        path: path of the recording
        car: vehicle whose parameters were to be used
        monitors: names of the monitors; None stands for all
        reason: reason, the same for all monitors
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
        path, car, dbc, channel_map, start, stop: see `judge`
        names: signals to be read; None reads all

    Raises:
        InputError: the stretch is empty
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


def require_readable(source: Path | Recording, car: Vehicle, dbc: Any, channel_map: Any) -> None:
    """Raise the errors of a file once, before every monitor would repeat them.

    Raises:
        InputError: the file cannot be read, or its channel map or database does not fit
    """
    if isinstance(source, Path) and not source.is_fifo():
        next(iter(pieces_of(source, None, car, dbc, channel_map, 1.0)))


def look_at(source: Path | Recording, car: Vehicle, dbc: Any, channel_map: Any) -> Look | None:
    """First piece of a recording, from which it is decided which monitors can run; None for a pipe.

    Raises:
        InputError: the recording cannot be read
    """
    if isinstance(source, Recording):
        return Look(source, whole=True)
    if source.is_fifo():
        return None
    piece = next(iter(pieces_of(source, read_by_any(), car, dbc, channel_map)))
    return Look(piece, whole=share_read(piece) >= 1.0)


def able(source: Path | Recording, car: Vehicle, dbc: Any, channel_map: Any) -> tuple[str, ...]:
    """Names of the monitors that would accept a recording, determined from its first piece.

    Raises:
        InputError: the recording cannot be read
    """
    return tuple(_able(source, car, dbc, channel_map))


def can_be_judged(source: Path | Recording, car: Vehicle, dbc: Any = None, channel_map: Any = None) -> bool:
    """Whether at least one monitor would accept a recording; see `able`."""
    return any(_able(source, car, dbc, channel_map))


def _able(source: Path | Recording, car: Vehicle, dbc: Any, channel_map: Any) -> Iterator[str]:
    look = look_at(source, car, dbc, channel_map)
    # A monitor without required signals has to be run on a sample of the recording: check the fast ones first.
    for each in sorted((MONITORS[chosen.monitor] for chosen in usual()), key=lambda each: not each.required):
        if look and taken(each, refusals(each, car, look.recording)):
            yield each.name
