"""MATLAB and HDF5 files: vectors beside a time vector or a sampling interval, structure by structure."""

from __future__ import annotations

import contextlib
import struct
import zlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.formats import require_library
from tierod.io.readers import vectors_child
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import is_time, require_plausible_rate, unit_of
from tierod.io.readers.clocks import seconds as to_seconds
from tierod.io.readers.content import BLOCK, Allowance
from tierod.io.readers.reader_process import ReaderProcess
from tierod.io.readers.source import Column, Format, Lane, Piece, Source

PERIODS = ("Ts", "ts", "dt", "Dt", "SampleTime", "sample_time")  # names of a sampling interval
SAMPLES = 1 << 16  # of a vector that are read at a time
_LEVEL_4 = 20  # bytes of the header of a matrix of level 4
_HEADER, _PACKED = 128, 15  # bytes before the first variable of MATLAB 5, type of a packed variable


class Data(NamedTuple):
    path: str
    length: int
    unit: str
    value: float | None  # of a number

    @property
    def parts(self) -> list[str]:
        """Names along the path, from the outermost structure to the vector."""
        return [part for part in self.path.replace("\0", "/").split("/") if part]


class Timed(NamedTuple):
    data: Data
    clock: Data | float  # a vector, or the sampling interval [s]


def open_mat(path: Path, given: TimeEntry = GUESSED) -> Source:
    """A MATLAB file of version 5 to 7.2; vectors are called by their structures and their own name."""
    _refuse_large(path)
    process = ReaderProcess(path, vectors_child, "SciPy", "MATLAB file")
    return _source(path, process, given, "MATLAB 5")


def open_hdf5(path: Path, given: TimeEntry = GUESSED) -> Source:
    """A MATLAB 7.3 or HDF5 file; vectors are called by the shortest name that is unique."""
    require_library("h5py", "hdf5", "reading a MATLAB 7.3 or HDF5 file")
    process = ReaderProcess(path, vectors_child, "the HDF5 library", "HDF5")
    return _source(path, process, given, "MATLAB 7.3 or HDF5")


def _source(path: Path, process: ReaderProcess, given: TimeEntry, kind: str) -> Source:
    whole = kind == "MATLAB 5"
    listed = _listed(path, process)
    timed = _timed(listed, given)
    if whole:
        longest = max((each.data.length for each in timed if isinstance(each.clock, float)), default=0)
        timed = [each for each in timed if isinstance(each.clock, Data) or each.data.length == longest]
    if not timed:
        raise InputError(
            f"{path} holds no vectors beside a time vector; save a vector 'time' in seconds with the signals"
        )
    often = Counter(each.data.parts[-1] for each in timed)
    signals = {
        ".".join(each.data.parts) if whole or often[each.data.parts[-1]] > 1 else each.data.parts[-1]: each
        for each in timed
    }
    clocks = {each.clock.path: each.clock for each in timed if isinstance(each.clock, Data)}
    units = {clock.path: clock.unit or unit_of(Column(clock.parts[-1]), given) for clock in clocks.values()}
    try:
        if given.column and not any(given.column in _names(clock) for clock in clocks.values()):
            raise InputError(f"the channel map names the time '{given.column}', but no vector has that name")
        heads = {name: _part(process, [name], 0, min(clock.length, 4096))[0] for name, clock in clocks.items()}
        require_plausible_rate((clocks[name].parts[-1], units[name], head) for name, head in heads.items())
        for name, head in heads.items():
            to_seconds(head, units[name], clocks[name].parts[-1])
    except InputError as error:
        raise InputError(f"{path}: {error}" if str(path) not in str(error) else str(error)) from None

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock: dict[str | float, list[str]] = {}
        for name in names:
            clock = signals[name].clock
            by_clock.setdefault(clock.path if isinstance(clock, Data) else clock, []).append(name)
        allowance = Allowance(path, path.stat().st_size)
        for members in by_clock.values():
            allowance.take(8 * (len(members) + 1) * signals[members[0]].data.length)
        mark = "." if whole else "/"
        return [_lane(process, {name: signals[name] for name in members}, units, mark) for members in by_clock.values()]

    several = len({tuple(each.data.parts[:-1]) for each in timed}) > 1
    columns = tuple(
        Column(name, each.data.unit, each.data.parts[-1], several and name != each.data.parts[-1])
        for name, each in signals.items()
    )
    used = {*clocks, *(each.data.path for each in timed)}
    left = [".".join(each.parts) for each in listed if each.value is None and each.path not in used]
    some = ", ".join(left[:3]) + ", ..." * (len(left) > 3)
    notes = (f"vectors without a time of their length were left out: {len(left)} ({some})",) if left else ()
    return Source(columns, lanes, {"format": kind}, warnings=notes)


def _listed(path: Path, process: ReaderProcess) -> list[Data]:
    listed, units = list[Data](), dict[str, str]()
    try:
        for about, _ in process.answers({}):
            units |= {str(name): str(unit)[:60] for name, unit in about.get("units", {}).items()}
            for each in about["found"]:
                listed.append(Data(str(each["path"]), int(each["count"]), str(each["unit"])[:60], each.get("value")))
        return [each._replace(unit=each.unit or units.get(each.parts[-1], "")) for each in listed]
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{path} is damaged, and its contents cannot be listed; export it again") from None


def _names(data: Data) -> tuple[str, ...]:
    return data.parts[-1], "/".join(data.parts), ".".join(data.parts)


def _timed(listed: Sequence[Data], given: TimeEntry) -> list[Timed]:
    """Vectors with the clock of their structure, or of one around it where the lengths agree."""
    groups: dict[tuple[str, ...], list[Data]] = {}
    for each in listed:
        groups.setdefault(tuple(each.parts[:-1]), []).append(each)
    clocks = {where: _clock(members, given) for where, members in groups.items()}
    found = []
    for where, members in groups.items():
        own = {each.parts[-1].lower(): each for each in members if each.value is None}
        apart = {each.path: beside for each in members if not given.column and (beside := _own_clock(each, own))}
        around = [where[:depth] for depth in range(len(where), -1, -1)]
        known = [clock for above in around if (clock := clocks.get(above)) is not None]
        taken = {id(clock) for clock in (*known, *apart.values())}
        for each in members:
            if each.value is not None or id(each) in taken:
                continue
            fitting = (
                [apart[each.path]]
                if each.path in apart
                else [clock for clock in known if not isinstance(clock, Data) or clock.length == each.length]
            )
            if fitting:
                found.append(Timed(each, fitting[0]))
    return found


def _own_clock(vector: Data, others: dict[str, Data]) -> Data | None:
    """The vector of the times of another one, called by its name and "time"."""
    name = vector.parts[-1].lower()
    words = (f"{name}_time", f"time_{name}", f"{name}_t", f"t_{name}", f"{name}time", f"{name}_timestamp")
    return next((others[word] for word in words if word in others and others[word].length == vector.length), None)


def _clock(members: Sequence[Data], given: TimeEntry) -> Data | float | None:
    vectors = [each for each in members if each.value is None]
    named = [each for each in vectors if given.column and given.column in _names(each)]
    named = named or [each for each in vectors if is_time(each.parts[-1])]
    if named:
        return named[0]
    return next((each.value for each in members if each.value and each.parts[-1] in PERIODS), None)


def _part(process: ReaderProcess, names: Sequence[str], begin: int, end: int) -> list[np.ndarray]:
    _, arrays = process.ask({"names": list(names), "begin": begin, "end": end})
    return [arrays[str(place)] for place in range(len(names))]


def _lane(process: ReaderProcess, signals: dict[str, Timed], units: dict[str, str], mark: str) -> Lane:
    """The signals with a common time, piece by piece."""
    clock = next(iter(signals.values())).clock
    count = max(each.data.length for each in signals.values())
    for begin in range(0, count, SAMPLES):
        end, note = min(begin + SAMPLES, count), ""
        if isinstance(clock, Data):
            time, note = to_seconds(_part(process, [clock.path], begin, end)[0], units[clock.path], clock.parts[-1])
        else:
            time = clock * np.arange(begin, end)
        values = _part(process, [each.data.path for each in signals.values()], begin, end)
        channels = []
        for (name, each), part in zip(signals.items(), values, strict=True):
            # Beside a sampling interval the vectors may differ in length.
            stamps = time if len(part) == len(time) else time[: len(part)]
            channels.append(Channel(name, stamps, part, each.data.unit, mark.join(each.data.parts), note))
        yield Piece(channels, end / count)


def _refuse_large(path: Path) -> None:
    """Unpack every packed variable of a MATLAB 5 file without keeping it, to check the unpacked size."""
    allowance = Allowance(path, path.stat().st_size)
    with path.open("rb") as file:
        if not file.read(_HEADER).startswith(b"MATLAB"):
            return  # level 4 packs nothing
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


def _is_hdf5(head: bytes, ending: str) -> bool:
    return head.startswith((b"\x89HDF\r\n\x1a\n", b"MATLAB 7.3")) or head[512:520] == b"\x89HDF\r\n\x1a\n"


def _is_mat(head: bytes, ending: str) -> bool:
    """Whether a file is of MATLAB 5, or of level 4: a matrix by its type, numbers of rows and columns, and name."""
    if head.startswith(b"MATLAB 5.0") or ending != ".mat" or len(head) < _LEVEL_4:
        return head.startswith(b"MATLAB 5.0")
    for place, order in enumerate("<>"):
        kind, rows, columns, imaginary, length = struct.unpack(f"{order}5i", head[:_LEVEL_4])
        shape = min(rows, columns) >= 0 and imaginary in (0, 1) and 1 < length < 1 << 10
        if shape and (kind // 1000, kind // 100 % 10) == (place, 0) and kind // 10 % 10 < 6 and kind % 10 < 3:
            return True
    return False


MAT = Format(
    "mat", "MATLAB 4, 5 (.mat)", (".mat",), lambda content, time: open_mat(content.path, time), _is_mat, whole=True,
)  # fmt: skip
HDF5 = Format(
    "hdf5", "MATLAB 7.3, HDF5 (.mat, .h5)", (".h5", ".hdf5"), lambda content, time: open_hdf5(content.path, time),
    _is_hdf5, whole=True,
)  # fmt: skip
