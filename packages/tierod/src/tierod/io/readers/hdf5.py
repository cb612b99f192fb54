"""MATLAB 7.3 files and HDF5 files with vectors beside a time vector, group by group."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.libraries import require_library
from tierod.io.readers import hdf_child
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import is_time, require_plausible_rate, unit_of
from tierod.io.readers.clocks import seconds as to_seconds
from tierod.io.readers.limits import Allowance
from tierod.io.readers.mat import PERIODS
from tierod.io.readers.reader_process import ReaderProcess
from tierod.io.readers.source import Column, Format, Lane, Piece, Source

SAMPLES = 1 << 16  # Number of samples of a vector that are read at a time


class Data(NamedTuple):
    """A vector or number in the file: its path there, its length, unit, and value where it is a number."""

    path: str
    length: int
    unit: str
    value: float | None

    @property
    def parts(self) -> list[str]:
        """Names along the path, from the outermost group to the vector."""
        return [part for part in self.path.replace("\0", "/").split("/") if part]


class Timed(NamedTuple):
    """A vector with its time: another vector, or its sampling interval [s]."""

    data: Data
    clock: Data | float


def open_hdf5(path: Path, given: TimeEntry = GUESSED) -> Source:
    """A MATLAB 7.3 or HDF5 file: every group (structure) with vectors beside a time vector or a sampling interval.

    A vector without a time in its own group takes that of a group around it, where the lengths agree.
    """
    require_library("h5py", "hdf5", "reading a MATLAB 7.3 or HDF5 file")
    process = ReaderProcess(path, hdf_child, "the HDF5 library", "HDF5")
    about, _ = process.ask({})
    try:
        listed = [
            Data(str(each["path"]), int(each["count"]), str(each["unit"])[:60], each.get("value"))
            for each in about["found"]
        ]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path} is damaged and cannot be read as HDF5; export it again") from None
    timed = _timed(listed, given)
    signals = _named(timed)
    if not signals:
        raise InputError(
            f"{path} holds no vectors beside a time vector; save a vector 'time' in seconds with the signals"
        )
    clocks = {each.clock.path: each.clock for each in timed if isinstance(each.clock, Data)}
    units = {clock.path: clock.unit or unit_of(Column(clock.parts[-1]), given) for clock in clocks.values()}
    heads = [
        (name, units[name], _part(process, [name], 0, min(clock.length, 4096))[0]) for name, clock in clocks.items()
    ]
    try:
        require_plausible_rate(heads)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock: dict[str | float, list[str]] = {}
        for name in names:
            clock = signals[name].clock
            by_clock.setdefault(clock.path if isinstance(clock, Data) else clock, []).append(name)
        allowance = Allowance(path, path.stat().st_size)
        for members in by_clock.values():
            allowance.take(8 * (len(members) + 1) * signals[members[0]].data.length)
        return [_lane(process, {name: signals[name] for name in members}, units) for members in by_clock.values()]

    several = len({tuple(each.data.parts[:-1]) for each in timed}) > 1
    columns = tuple(
        Column(name, each.data.unit, each.data.parts[-1], several and name != each.data.parts[-1])
        for name, each in signals.items()
    )
    return Source(columns, lanes, {"format": "MATLAB 7.3 or HDF5"})


def _timed(listed: Sequence[Data], given: TimeEntry) -> list[Timed]:
    groups: dict[tuple[str, ...], list[Data]] = {}
    for each in listed:
        groups.setdefault(tuple(each.parts[:-1]), []).append(each)
    clocks = {where: _clock(members, given) for where, members in groups.items()}
    found = []
    for where, members in groups.items():
        around = [where[:depth] for depth in range(len(where), -1, -1)]
        known = [clock for above in around if (clock := clocks.get(above)) is not None]
        for each in members:
            if each.value is not None or any(each is clock for clock in known):
                continue
            fitting = [clock for clock in known if not isinstance(clock, Data) or clock.length == each.length]
            if fitting:
                found.append(Timed(each, fitting[0]))
    return found


def _clock(members: Sequence[Data], given: TimeEntry) -> Data | float | None:
    vectors = [each for each in members if each.value is None]
    named = [each for each in vectors if given.column and given.column in (each.parts[-1], "/".join(each.parts))]
    named = named or [each for each in vectors if is_time(each.parts[-1])]
    if named:
        return named[0]
    return next((each.value for each in members if each.value and each.parts[-1] in PERIODS), None)


def _named(timed: Sequence[Timed]) -> dict[str, Timed]:
    """Vectors by the shortest name that is unique: that of the vector alone, or with its groups."""
    often: dict[str, int] = {}
    for each in timed:
        often[each.data.parts[-1]] = often.get(each.data.parts[-1], 0) + 1
    return {
        (each.data.parts[-1] if often[each.data.parts[-1]] == 1 else ".".join(each.data.parts)): each for each in timed
    }


def _part(process: ReaderProcess, names: Sequence[str], begin: int, end: int) -> list[np.ndarray]:
    _, arrays = process.ask({"names": list(names), "begin": begin, "end": end})
    return [arrays[str(place)] for place in range(len(names))]


def _lane(process: ReaderProcess, signals: dict[str, Timed], units: dict[str, str]) -> Lane:
    """The signals with a common time, piece by piece."""
    first = next(iter(signals.values()))
    clock, count = first.clock, first.data.length
    count = max(each.data.length for each in signals.values()) if not isinstance(clock, Data) else count
    for begin in range(0, count, SAMPLES):
        end = min(begin + SAMPLES, count)
        note = ""
        if isinstance(clock, Data):
            time, note = to_seconds(_part(process, [clock.path], begin, end)[0], units[clock.path], clock.parts[-1])
        else:
            time = clock * np.arange(begin, end)
        values = _part(process, [each.data.path for each in signals.values()], begin, end)
        channels = []
        for (name, each), part in zip(signals.items(), values, strict=True):
            # Beside a sampling interval the vectors may differ in length.
            stamps = time if len(part) == len(time) else time[: len(part)]
            channels.append(Channel(name, stamps, part, each.data.unit, "/".join(each.data.parts), note))
        yield Piece(channels, end / count)


def _recognised(head: bytes, ending: str) -> bool:
    return head.startswith((b"\x89HDF\r\n\x1a\n", b"MATLAB 7.3")) or head[512:520] == b"\x89HDF\r\n\x1a\n"


FORMAT = Format(
    "hdf5",
    "MATLAB 7.3, HDF5 (.mat, .h5)",
    (".h5", ".hdf5"),
    lambda content, time: open_hdf5(content.path, time),
    _recognised,
    whole=True,
)
