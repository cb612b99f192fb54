"""Slices of equal length from the lanes of one file, or of several files of one drive."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.core.series import CALENDAR, LATE, Repairs, finite_or_missing, infinite_note
from tierod.io.readers.content import Allowance
from tierod.io.readers.source import Column, Lane, Piece, Source

# Time stamps in order [s], shape (n,), and the values of the channels that they belong to, (n,) each
Stretch = tuple[np.ndarray, dict[str, np.ndarray]]


FEWEST = 0.1  # Smallest mean sampling rate within a slice [Hz]; a slice costs some milliseconds, even with few samples


class Slice(NamedTuple):
    """All channels over the same time.

    A slice with a lower mean sampling rate than `FEWEST` is extended until it has enough samples, so that the effort
    depends on the number of samples, whatever their stamps are.
    """

    channels: list[Channel]  # usable channels; notes on repairs count from the beginning of the recording
    share: float  # share of the file that has been read, 0 to 1


class _Clock:
    """Channels with common time stamps, whose sorted samples wait until a slice is full."""

    def __init__(self, channels: list[Channel]):
        self.about = {channel.name: channel for channel in channels}
        self.repairs = Repairs(f"'{channels[0].name}'")
        self.infinite = dict.fromkeys(self.about, 0)
        self.waiting: list[Stretch] = []

    def add(self, channels: list[Channel]) -> None:
        time = np.asarray(channels[0].time, dtype=float)
        values = {channel.name: _values(channel, time) for channel in channels}
        self.about |= {channel.name: channel for channel in channels}
        kept = self.repairs.arrived(time)
        if kept is not None:
            time, values = time[kept], {name: each[kept] for name, each in values.items()}
        if not len(time):
            return
        if self.repairs.in_order:
            self.waiting.append((time, values))
            return
        # Late samples: only the stretches that overlap with them are sorted again.
        least = float(time.min())
        overlapping: list[Stretch] = []
        while self.waiting and self.waiting[-1][0][-1] > least:
            overlapping.insert(0, self.waiting.pop())
        joined, columns = _joined([*overlapping, (time, values)], list(self.about))
        put = np.argsort(joined, kind="stable")
        self.waiting.append((joined[put], {name: each[put] for name, each in columns.items()}))

    def first(self) -> float:
        return float(self.waiting[0][0][0]) if self.waiting else math.inf

    def filled(self, samples: int) -> float:
        """Stamp that follows a number of waiting samples [s]; infinity where no more wait."""
        for time, _ in self.waiting:
            if samples < len(time):
                return float(time[samples])
            samples -= len(time)
        return math.inf

    def taken(self, stop: float) -> list[Channel]:
        ready: list[Stretch] = []
        while self.waiting and self.waiting[0][0][0] < stop:
            time, values = self.waiting.pop(0)
            last = int(np.searchsorted(time, stop, side="left"))
            ready.append((time[:last], {name: each[:last] for name, each in values.items()}))
            if last < len(time):
                self.waiting.insert(0, (time[last:], {name: each[last:] for name, each in values.items()}))
        time, columns = _joined(ready, list(self.about))
        self.repairs.settled(time)
        made, notes = [], self.repairs.notes
        for name, channel in self.about.items():
            usable, infinite = finite_or_missing(columns[name])
            self.infinite[name] += infinite
            fit = Channel(name, time, usable, channel.unit, channel.source, channel.note)
            made.append(fit.noted(*notes, infinite_note(self.infinite[name])))
        return made


def _values(channel: Channel, time: np.ndarray) -> np.ndarray:
    values = np.asarray(channel.values)
    if values.shape != time.shape or values.ndim != 1:
        raise InputError(
            f"channel '{channel.name}' needs as many time stamps as values, not {time.shape} and {values.shape}; "
            "export the recording again"
        )
    return np.asarray(values, dtype=float)


def _joined(stretches: list[Stretch], names: list[str]) -> Stretch:
    """Stretches joined to one; a channel that one of them lacks is NaN there."""
    if len(stretches) == 1 and len(stretches[0][1]) == len(names):
        return stretches[0]
    if not stretches:
        return np.empty(0), {name: np.empty(0) for name in names}
    time = np.concatenate([each[0] for each in stretches])
    values = {}
    for name in names:
        parts = [
            each[1].pop(name, None) for each in stretches
        ]  # popped, so that no channel is twice in memory for long
        values[name] = np.concatenate(
            [
                np.full(len(each[0]), np.nan) if part is None else part
                for part, each in zip(parts, stretches, strict=True)
            ]
        )
    return time, values


class _Lane:
    """One lane of a file: the time up to which its channels are complete, and their waiting samples."""

    def __init__(self, pieces: Lane, allowance: Allowance):
        self._pieces, self._allowance = pieces, allowance
        self.clocks: dict[str, _Clock] = {}
        self.reach, self.share = -math.inf, 0.0

    def advance(self) -> None:
        piece = next(self._pieces, None)
        if piece is None:
            self.reach, self.share = math.inf, 1.0
            return
        self.share = piece.share
        together: dict[int, list[Channel]] = {}
        for channel in piece.channels:
            together.setdefault(id(channel.time), []).append(channel)
        for channels in together.values():
            clocks: dict[int, list[Channel]] = {}
            for channel in channels:
                known = self.clocks.get(channel.name)
                clocks.setdefault(id(known) if known else 0, []).append(channel)
            for members in clocks.values():
                clock = self.clocks.get(members[0].name)
                if clock is None:
                    clock = _Clock(members)
                    self.clocks |= dict.fromkeys((member.name for member in members), clock)
                self._allowance.take(8 * (len(members) + 1) * len(members[0].time))
                clock.add(members)
        newest = max((clock.repairs.newest for clock in self.clocks.values()), default=-math.inf)
        # The next piece may bring samples that belong before the last of this one.
        self.reach = newest - LATE


def slices(lanes: Iterable[Lane], seconds: float, allowance: Allowance) -> Iterator[Slice]:
    """Consecutive slices of all lanes, which do not depend on the pieces; slices without a sample are left out.

    Args:
        lanes: lanes of a file; one lags behind another by no more than the length of a piece
        seconds: length of the slices [s], counted from the first stamp of all; infinity gives a single slice
    """
    running = [_Lane(lane, allowance) for lane in lanes]
    start = math.nan
    while running:
        laggard = min(running, key=lambda lane: lane.reach)
        until = laggard.reach
        if until > -math.inf:
            while (first := _first(running)) < until:
                start = first if math.isnan(start) else _begin_of_slice(start, seconds, first)
                # At a stamp of 1e18 s ten minutes are less than the last bit: then all the rest is one slice.
                stop = start + seconds if start + seconds > first else math.inf
                stop = max(stop, _filled(running, seconds))
                if stop > until:
                    break
                yield _taken(running, stop)
        if until == math.inf:
            for clock in (clock for lane in running for clock in _clocks(lane)):
                clock.repairs.refuse_unusable()
            return
        laggard.advance()


def _first(lanes: list[_Lane]) -> float:
    return min((clock.first() for lane in lanes for clock in _clocks(lane)), default=math.inf)


def _filled(lanes: list[_Lane], seconds: float) -> float:
    """Time at which the densest channels have the smallest number of samples of a slice [s]."""
    samples = math.floor(FEWEST * seconds) if math.isfinite(seconds) else 0
    return min((clock.filled(samples) for lane in lanes for clock in _clocks(lane)), default=math.inf)


def _begin_of_slice(start: float, seconds: float, first: float) -> float:
    """Start of the slice that holds the stamp `first`, whole slices after `start`."""
    count = (first - start) / seconds
    start += seconds * math.floor(count) if math.isfinite(count) else 0.0
    while start < start + seconds <= first:
        start += seconds
    return start


def _clocks(lane: _Lane) -> list[_Clock]:
    return list(dict.fromkeys(lane.clocks.values()))


def _taken(lanes: list[_Lane], stop: float) -> Slice:
    channels = [channel for lane in lanes for clock in _clocks(lane) for channel in clock.taken(stop)]
    return Slice(channels, sum(lane.share for lane in lanes) / len(lanes))


STRETCH = 10.0  # Length of a stretch of a part that is read at once [s]


@dataclass(frozen=True)
class Part:
    path: Path
    source: Source
    begin: float


def joined_source(opened: Sequence[tuple[Path, Source]]) -> Source:
    """The files as one, in the order of their time, whatever the order in which they are given."""
    parts = sorted((Part(path, source, _begin(path, source)) for path, source in opened), key=lambda part: part.begin)
    columns: dict[str, Column] = {}
    for part in parts:
        for column in part.source.columns:
            known = columns.setdefault(column.name, column)
            if known.unit != column.unit:
                raise InputError(
                    f"'{column.name}' is in '{known.unit}' in {parts[0].path} and in '{column.unit}' in {part.path}; "
                    "they are not parts of one drive: convert them one by one"
                )
    origin = parts[0].source.origin
    warnings = tuple(dict.fromkeys(text for part in parts for text in part.source.warnings))
    return Source(
        tuple(columns.values()),
        lambda names: [_lane(parts, names)],
        {**parts[0].source.metadata, "parts": [str(part.path) for part in parts]},
        origin,
        warnings,
        lambda: tuple(dict.fromkeys(text for part in parts for text in part.source.found())),
        sum(part.source.size for part in parts),
        tuple(dict.fromkeys(each for part in parts for each in part.source.maps)),
        tuple(name for name in parts[0].source.silent if name not in columns),
        tuple(dict.fromkeys(each for part in parts for each in part.source.texts)),
    )


def _begin(path: Path, source: Source) -> float:
    """Time of the first sample [s], by the calendar where the file has one."""
    names = [column.name for column in source.columns]
    first = next(slices(source.lanes(names), STRETCH, Allowance(path, source.size)), None)
    stamps = [float(each.time[0]) for each in first.channels if len(each.time)] if first else []
    if not stamps:
        raise InputError(f"{path} holds no sample; leave it out")
    return source.origin + min(stamps)


def _lane(parts: Sequence[Part], names: Sequence[str]) -> Lane:
    """The wanted columns of all parts, one after the other, counted from the origin of the first."""
    done, last, size = 0.0, -math.inf, sum(part.source.size for part in parts) or 1
    first = parts[0]
    for part in parts:
        if (part.source.origin + part.begin > CALENDAR) != (first.source.origin + first.begin > CALENDAR):
            raise InputError(
                f"{part.path} and {first.path} are not timed alike: one has calendar time and the other has none; "
                "convert them one by one"
            )
        held = {column.name for column in part.source.columns}
        lanes = part.source.lanes([name for name in names if name in held])
        before = last
        for loaded, share in slices(lanes, STRETCH, Allowance(part.path, part.source.size)):
            channels = shifted(loaded, first.source.origin - part.source.origin)
            stamps = [each.time for each in channels if len(each.time)]
            if min((float(each[0]) for each in stamps), default=math.inf) < before - LATE:
                raise InputError(
                    f"{part.path} begins before the part ahead of it ends; give parts of one drive, whose time goes "
                    "on from file to file"
                )
            last = max(last, max((float(each[-1]) for each in stamps), default=last))
            yield Piece(channels, (done + share * part.source.size) / size)
        done += part.source.size


def parts_in(folder: Path, endings: Sequence[str]) -> list[Path]:
    """The recordings in a folder with the most frequent ending."""
    files = sorted(each for each in folder.iterdir() if each.is_file() and each.suffix.lower() in endings)
    often = {ending: sum(each.suffix.lower() == ending for each in files) for ending in endings}
    chosen = [each for each in files if each.suffix.lower() == max(often, key=lambda ending: often[ending])]
    if not chosen:
        raise InputError(f"{folder} is a folder without a recording; give a recording, or a folder with parts of one")
    return chosen


def shifted(channels: Sequence[Channel], origin: float) -> list[Channel]:
    """The channels with their time counted from `origin` [s]; stamps that are shared stay shared."""
    moved: dict[int, np.ndarray] = {}
    for channel in channels:
        if id(channel.time) not in moved:
            moved[id(channel.time)] = np.asarray(channel.time, dtype=float) - origin
    return [replace(channel, time=moved[id(channel.time)]) for channel in channels]
