"""Stored signals: every sample as recorded, and extrema in levels of resolution, so that any zoom reads little.

A bin of level 1 holds 16 samples, a bin of each further level four times as many. A reader maps the files into memory,
so that a picture of ten hours reads a few thousand bins.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from tierod.core.decimation import extremes
from tierod.core.errors import InputError
from tierod.core.files import write_text
from tierod.core.recording import Channel, Recording
from tierod.web.errors import Absent, TooLarge

FIRST, FACTOR = 16, 4
"""Number of samples per bin of the first level, and number of bins merged into one of the next level."""

LEAST_BINS = 256  # Smallest number of bins of a level; coarser levels are not made

MOST_MAPPED = 512  # Largest number of files of a recording that stay mapped into memory

INDEX = "index.json"


@dataclass
class Kept:
    """One stored signal."""

    name: str  # name, unit, source, note: as in a channel; "monitor/name" is the estimate of a monitor
    unit: str
    source: str
    note: str
    stamps: int  # number of its time stamps' file
    file: int  # number of the file with its values
    count: int = 0


class Window(NamedTuple):
    """A time span of a signal for a picture."""

    time: np.ndarray  # times of the samples, or left edges of the bins [s]
    lower: np.ndarray  # lower, upper: minima and maxima of the bins; the same array if it holds every sample
    upper: np.ndarray
    exact: bool  # whether every sample of the span is included


class SeriesWriter:
    """Writes signals piece by piece; its memory does not grow with their length.

    Args:
        folder: empty folder for the files
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.signals: dict[str, Kept] = {}
        self._counts: list[int] = []
        self._files: dict[str, IO[bytes]] = {}
        self._numbers = 0

    def add(self, channels: Iterable[Channel]) -> None:
        """Add the next piece of some signals; signals with the same array of time stamps share one file of stamps."""
        added: dict[int, np.ndarray] = {}
        taken: dict[int, int] = {}
        for channel in channels:
            if not len(channel.time):
                continue
            kept = self.signals.get(channel.name)
            if kept is None:
                kept = self._new(channel, taken.get(id(channel.time)))
            elif (kept.stamps in added and not np.array_equal(added[kept.stamps], channel.time)) or (
                kept.stamps not in added and kept.count != self._counts[kept.stamps]
            ):
                self._part(kept)
            if kept.stamps not in added:
                self._append(f"t{kept.stamps}.f8", channel.time)
                self._counts[kept.stamps] += len(channel.time)
                added[kept.stamps] = channel.time
            taken[id(channel.time)] = kept.stamps
            self._append(f"c{kept.file}.f8", channel.values)
            kept.count += len(channel.time)

    def finish(self, facts: Mapping[str, object]) -> None:
        """Write the levels and the index."""
        for file in self._files.values():
            file.close()
        stamps = sorted({each.stamps for each in self.signals.values()})
        for number in stamps:
            time = _mapped(self.folder / f"t{number}.f8", np.float64)
            for level, width in enumerate(_widths(len(time)), 1):
                (self.folder / f"t{number}.l{level}").write_bytes(np.ascontiguousarray(time[::width]).tobytes())
        for each in self.signals.values():
            _write_levels(self.folder, each)
        span = [self._edge(stamps, 0, min), self._edge(stamps, -1, max)] if stamps else [0.0, 0.0]
        content = {"span": span, "facts": dict(facts), "signals": [asdict(each) for each in self.signals.values()]}
        write_text(self.folder / INDEX, json.dumps(content), sweeps=False)

    def _edge(self, stamps: list[int], place: int, of: object) -> float:
        edges = [float(_mapped(self.folder / f"t{number}.f8", np.float64)[place]) for number in stamps]
        return min(edges) if of is min else max(edges)

    def _new(self, channel: Channel, stamps: int | None) -> Kept:
        if stamps is None or self._counts[stamps] != len(channel.time):
            stamps = len(self._counts)
            self._counts.append(0)
        kept = Kept(channel.name, channel.unit, channel.source, channel.note, stamps, self._numbers)
        self._numbers += 1
        self.signals[channel.name] = kept
        return kept

    def _part(self, kept: Kept) -> None:
        """Give a signal a file of time stamps of its own, when its stamps deviate from those shared so far."""
        old, kept.stamps = kept.stamps, len(self._counts)
        self._counts.append(kept.count)
        # Mapped below, so that the buffered stamps must be in the file.
        if file := self._files.get(f"t{old}.f8"):
            file.flush()
        self._append(f"t{kept.stamps}.f8", _mapped(self.folder / f"t{old}.f8", np.float64)[: kept.count])

    def _append(self, name: str, values: np.ndarray) -> None:
        file = self._files.get(name)
        if file is None:
            # Few enough for the limit of open files of a process.
            if len(self._files) >= 200:
                self._files.pop(next(iter(self._files))).close()
            file = self._files[name] = open(self.folder / name, "ab")  # noqa: SIM115  (closed in finish)
        file.write(np.ascontiguousarray(values, np.float64).data)


def _mapped(path: Path, kind: type[np.generic]) -> np.ndarray:
    return np.memmap(path, kind, "r") if path.stat().st_size else np.empty(0, kind)


def _widths(count: int) -> list[int]:
    """Number of samples per bin of every level."""
    widths, width = [], FIRST
    while count // width >= LEAST_BINS:
        widths.append(width)
        width *= FACTOR
    return widths


def _write_levels(folder: Path, kept: Kept) -> None:
    values = _mapped(folder / f"c{kept.file}.f8", np.float64)
    widths = _widths(len(values))
    if not widths:
        return
    lower, upper = extremes(values, values, FIRST)
    for level, _ in enumerate(widths, 1):
        if level > 1:
            lower, upper = extremes(lower, upper, FACTOR)
        content = np.stack([lower, upper], axis=1).astype("<f4")
        (folder / f"c{kept.file}.l{level}").write_bytes(content.tobytes())


@dataclass
class SeriesReader:
    """Reader of the stored signals of a recording.

    Raises:
        Absent: the folder does not exist any more
    """

    folder: Path
    span: tuple[float, float] = (0.0, 0.0)
    facts: dict[str, object] = field(default_factory=dict)
    signals: dict[str, Kept] = field(default_factory=dict)

    def __post_init__(self) -> None:
        try:
            content = json.loads((self.folder / INDEX).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise Absent("the analysed recording is not kept any more; open it again from the list") from None
        self.span, self.facts = (content["span"][0], content["span"][1]), content["facts"]
        self.signals = {each["name"]: Kept(**each) for each in content["signals"]}
        # A finished folder does not change, and mapping a file takes longer than reading a picture from it.
        self._map = lru_cache(MOST_MAPPED)(lambda name, kind: _mapped(self.folder / name, kind))

    def of(self, name: str) -> Kept:
        if name not in self.signals:
            raise Absent(f"the recording has no signal '{name[:100]}'; choose one from the list of signals")
        return self.signals[name]

    def samples(self, name: str, start: float = -np.inf, stop: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """(time, values) of every sample from start up to, but not including, stop [s]; raises as `of`."""
        kept = self.of(name)
        time, values = self._files(kept)
        first, last = np.searchsorted(time, (start, stop), side="left")
        return np.asarray(time[first:last]), np.asarray(values[first:last])

    def window(self, name: str, start: float, stop: float, points: int) -> Window:
        """A time span of a signal for a picture, with one sample before and one after it."""
        kept = self.of(name)
        time, values = self._files(kept)
        first, last = self._between(kept, time, start, stop)
        if last - first <= 2 * points:
            exact = np.asarray(values[first:last])
            return Window(np.asarray(time[first:last]), exact, exact, True)
        widths = [1, *_widths(len(time))]
        level = max(place for place, width in enumerate(widths) if (last - first) // width >= points or not place)
        width = widths[level]
        begin, end = first // width, -(-last // width)
        if level:
            bins = self._map(f"c{kept.file}.l{level}", np.float32).reshape(-1, 2)[begin:end]
            edges = self._map(f"t{kept.stamps}.l{level}", np.float64)[begin:end]
            lower, upper = bins[:, 0], bins[:, 1]
        else:
            edges, lower = time[begin:end], values[begin:end]
            upper = lower
        step = max(len(lower) // points, 1)
        low, high = extremes(np.asarray(lower, float), np.asarray(upper, float), step)
        return Window(np.asarray(edges[::step]), low, high, False)

    def recording(self, names: Iterable[str], start: float, stop: float) -> Recording:
        """Every sample of some signals from start up to (not including) stop [s], as a recording; raises as `of`."""
        channels = []
        for name in names:
            kept = self.of(name)
            channels.append(Channel(name, *self.samples(name, start, stop), kept.unit, kept.source, kept.note))
        return Recording({each.name: each for each in channels}, dict(self.facts))

    def _files(self, kept: Kept) -> tuple[np.ndarray, np.ndarray]:
        try:
            time, values = self._map(f"t{kept.stamps}.f8", np.float64), self._map(f"c{kept.file}.f8", np.float64)
        except OSError:
            raise Absent("the analysed recording is not kept any more; open it again from the list") from None
        return time[: kept.count], values[: kept.count]

    def _between(self, kept: Kept, time: np.ndarray, start: float, stop: float) -> tuple[int, int]:
        first = int(np.searchsorted(time, start, side="left"))
        last = int(np.searchsorted(time, stop, side="right"))
        return max(first - 1, 0), min(last + 1, len(time))


MOST_NAMES = 64  # Largest number of signals in one picture

MOST_POINTS = 10_000  # Largest number of points in a picture

MOST_EXPORTED = 20_000_000  # Largest number of samples of an export, over all signals


def windows(
    readers: Sequence[SeriesReader], names: Sequence[str], start: float | None, stop: float | None, points: int
) -> list[tuple[str, Window]]:
    """(name, time span) of some signals."""
    if not 1 <= len(names) <= MOST_NAMES:
        raise InputError(f"{len(names)} signals are asked for; give 1 to {MOST_NAMES}")
    if not 10 <= points <= MOST_POINTS:
        raise InputError(f"{points} points are asked for; give 10 to {MOST_POINTS}")
    begin, end = _stretch(readers[0], start, stop)
    return [(name, _holding(readers, name).window(name, begin, end, points)) for name in names]


def _stretch(reader: SeriesReader, start: float | None, stop: float | None) -> tuple[float, float]:
    first, last = reader.span
    begin, end = first if start is None else start, last if stop is None else stop
    if not (np.isfinite([begin, end]).all() and begin <= end):
        raise InputError(f"a stretch from {begin:g} to {end:g} s is empty; give a begin before its end")
    return begin, end


def _holding(readers: Sequence[SeriesReader], name: str) -> SeriesReader:
    return next((each for each in readers if name in each.signals), readers[0])


def packet(found: Sequence[tuple[str, Window]]) -> bytes:
    """Time spans in one packet: length of the header, the header as JSON, then numbers, little-endian.

    The header states for every signal its count and whether every sample is included. Numbers are the time stamps as
    float64, then minima and, if not every sample is included, maxima as float32.
    """
    head = [{"name": name, "count": len(each.time), "exact": each.exact} for name, each in found]
    text = json.dumps(head).encode()
    # Padded to eight bytes, the alignment that the typed arrays of the browser require.
    text += b" " * (-(4 + len(text)) % 8)
    parts = [struct.pack("<I", len(text)), text]
    for _, each in found:
        parts.append(np.ascontiguousarray(each.time, "<f8").tobytes())
        values = [each.lower] if each.exact else [each.lower, each.upper]
        with np.errstate(over="ignore"):
            content = b"".join(np.ascontiguousarray(one, "<f4").tobytes() for one in values)
        parts.append(content + b"\0" * (-len(content) % 8))
    return b"".join(parts)


def export(
    readers: Sequence[SeriesReader], names: Sequence[str], start: float | None, stop: float | None, path: Path
) -> None:
    """Write every sample of some signals over a time span; further arguments and errors as in `windows`."""
    from tierod.io.writers import write

    # The end is included: `recording` excludes its upper limit.
    begin, end = _stretch(readers[0], start, stop)
    parts = [_holding(readers, name).recording([name], begin, np.nextafter(end, np.inf)) for name in names]
    whole = Recording({name: each[name] for name, each in zip(names, parts, strict=True)}, parts[0].metadata)
    if "path" in whole.metadata:  # an export must not reveal paths on the server
        whole = replace(whole, metadata={**whole.metadata, "path": Path(str(whole.metadata["path"])).name})
    count = sum(len(each.time) for each in whole.channels.values())
    if count > MOST_EXPORTED:
        raise TooLarge(f"{count} samples are more than {MOST_EXPORTED} at once; zoom in, or choose fewer signals")
    if not count:
        raise InputError("there are no samples in this stretch; choose another")
    write(whole, path)
