"""MATLAB 5 files through SciPy: vectors and structures of vectors beside a time vector."""

from __future__ import annotations

import contextlib
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import is_time, require_plausible_rate, unit_of
from tierod.io.readers.clocks import seconds as to_seconds
from tierod.io.readers.content import BLOCK, Kept
from tierod.io.readers.limits import Allowance
from tierod.io.readers.reader_process import MatProcess
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with

# Names of a sampling interval beside vectors without a time
PERIODS = ("Ts", "ts", "dt", "Dt", "SampleTime", "sample_time")

SAMPLES = 1 << 17  # Number of samples of a vector that are read at a time
_HEADER, _PACKED = 128, 15  # Number of bytes before the first variable, and the type of a packed variable


def open_mat(path: Path, given: TimeEntry = GUESSED) -> Source:
    """A MATLAB file of version 5 to 7.2."""
    kept = Kept()
    content = _content(path, kept)
    signals: dict[str, Signal] = {}
    clocks: list[tuple[str, str, np.ndarray]] = []
    for prefix, members in _structures("", content):
        for signal in _timed(prefix, members, given, clocks):
            signals.setdefault(signal.name, signal)
    try:
        if given.column and given.column not in [name for name, *_ in clocks]:
            raise InputError(f"the channel map names the time '{given.column}', but no vector has that name")
        require_plausible_rate(clocks)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if not signals:
        raise InputError(f"{path} holds no vectors beside a time vector; save a vector 't' in seconds with the signals")
    several = len({name.rpartition(".")[0] for name in signals}) > 1
    units = content.get("units")
    units = {name: text for name, text in units.items() if isinstance(text, str)} if isinstance(units, dict) else {}
    columns = tuple(
        Column(name, units.get(title := name.rpartition(".")[2], ""), title, several and "." in name)
        for name in signals
    )

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock: dict[tuple[str, int], list[Signal]] = {}
        for name in names:
            by_clock.setdefault((signals[name].prefix, signals[name].values.count), []).append(signals[name])
        return [_lane(members, units) for members in by_clock.values()]

    return Source(columns, lanes, {"format": "MATLAB 5"})


@dataclass(frozen=True)
class Vector:
    """A vector of the file, kept in a temporary file."""

    kept: Kept  # the temporary file
    at: int  # position of its first byte there
    count: int  # number of its numbers

    def part(self, begin: int, end: int) -> np.ndarray:
        """Its numbers from `begin` up to `end`."""
        data = self.kept.read((min(end, self.count) - begin) * 8, self.at + begin * 8)
        return np.frombuffer(data, dtype="<f8").astype(float)


@dataclass(frozen=True)
class Signal:
    """A vector that has as many samples as its time."""

    prefix: str  # name of the structure that holds it
    name: str  # its name with that prefix
    values: Vector  # values as stored
    clock: Vector | float  # its time, or its sampling interval [s]
    unit: str = ""  # unit of the time


def _content(path: Path, kept: Kept) -> dict[str, Any]:
    """The variables of a file, loaded some at a time, with their vectors in a temporary file."""
    _refuse_large(path)
    process = MatProcess(path)
    found: dict[str, Any] = {}
    while True:
        about, vectors = process.ask({})
        if about.get("newer"):
            raise InputError(f"{path} is a MATLAB 7.3 file whose beginning is damaged; export it again")
        if about["end"]:
            return found
        found |= {name: _kept(value, vectors, kept) for name, value in about["variables"].items()}


def _refuse_large(path: Path) -> None:
    """Unpack every packed variable without keeping it, to check the unpacked size."""
    allowance = Allowance(path, path.stat().st_size)
    with path.open("rb") as file:
        file.seek(_HEADER)
        while len(tag := file.read(8)) == 8:
            kind, size = np.frombuffer(tag, dtype="<u4").tolist()
            if kind != _PACKED:
                file.seek(size, 1)
                continue
            worker = zlib.decompressobj()
            while size > 0 and (data := file.read(min(size, BLOCK))):
                size -= len(data)
                with contextlib.suppress(zlib.error):  # damage is reported by the reader
                    while data:
                        allowance.take(len(worker.decompress(data, BLOCK)))
                        data = worker.unconsumed_tail


def _kept(value: object, vectors: Mapping[str, np.ndarray], kept: Kept) -> object:
    if isinstance(value, list):
        return [_kept(entry, vectors, kept) for entry in value]
    if not isinstance(value, dict):
        return value
    numbers = vectors.get(value["vector"]) if [*value] == ["vector"] and isinstance(value["vector"], str) else None
    if numbers is None:
        return {name: _kept(entry, vectors, kept) for name, entry in value.items()}
    vector = Vector(kept, kept.size, len(numbers))
    kept.append(numbers.tobytes())
    return vector


def _lane(signals: list[Signal], units: Mapping[str, str]) -> Lane:
    """The signals of one structure with a common time, piece by piece."""
    first = signals[0]
    for begin in range(0, first.values.count, SAMPLES):
        end = min(begin + SAMPLES, first.values.count)
        if isinstance(first.clock, Vector):
            time, note = to_seconds(first.clock.part(begin, end), first.unit, first.name)
        else:
            time, note = first.clock * np.arange(begin, end), ""
        yield Piece(
            [
                Channel(
                    each.name,
                    time,
                    each.values.part(begin, end),
                    units.get(each.name.rpartition(".")[2], ""),
                    each.name,
                    note,
                )
                for each in signals
            ],
            end / first.values.count,
        )


def _structures(prefix: str, members: Mapping[str, object]) -> Iterator[tuple[str, Mapping[str, object]]]:
    """(name, members) of the file itself and of every structure in it."""
    yield prefix, members
    for name, value in members.items():
        full = f"{prefix}.{name}" if prefix else name
        if isinstance(value, dict):
            yield from _structures(full, value)
        elif isinstance(value, list):
            for number, entry in enumerate(value):
                if isinstance(entry, dict):
                    yield from _structures(f"{full}{number}", entry)


def _timed(
    prefix: str, members: Mapping[str, object], given: TimeEntry, clocks: list[tuple[str, str, np.ndarray]]
) -> Iterator[Signal]:
    """The vectors of one structure with as many samples as its time, or the longest ones beside a sampling interval.

    Its clock is added to `clocks`: name, unit ("" where none is given), first stamps as recorded.
    """
    vectors = {name: value for name, value in members.items() if isinstance(value, Vector)}
    name = next((name for name in vectors if name == given.column), None)
    name = name or next((name for name in vectors if is_time(name)), None)
    clock: Vector | float
    if name is not None:
        clock, unit = vectors.pop(name), unit_of(Column(name), given)
        clocks.append((name, unit, clock.part(0, SAMPLES)))
        count = clock.count
        to_seconds(clock.part(0, 1), unit, name)
    else:
        period = next(
            (members[name] for name in PERIODS if name in members and not isinstance(members[name], list)), None
        )
        if not isinstance(period, float) or not vectors:
            return
        clock, unit = float(period), ""
        count = max(value.count for value in vectors.values())
    for name, value in vectors.items():
        if value.count == count:
            yield Signal(prefix, f"{prefix}.{name}" if prefix else name, value, clock, unit)


FORMAT = Format(
    "mat",
    "MATLAB 5 (.mat)",
    (".mat",),
    lambda content, time: open_mat(content.path, time),
    begins_with(b"MATLAB 5.0"),
    whole=True,
)
