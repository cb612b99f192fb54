"""A recording in memory or in temporary files, whose rows a writer can take in any order."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import OutputError
from tierod.core.recording import Channel, Recording
from tierod.io.formats import plain
from tierod.io.readers.content import Kept
from tierod.io.readers.reading import LACKING, SHARE_READ

# Metadata of a recording that are not written, since the next reader determines them
_OF_READING = ("origin", "format", SHARE_READ, LACKING)

ROWS = 1 << 15  # Number of rows that a writer takes at a time


class _InMemory:
    def __init__(self, values: np.ndarray):
        self.values, self.count = np.ascontiguousarray(values, dtype="<f8"), len(values)

    def digest(self) -> bytes:
        return hashlib.blake2b(self.values.data, digest_size=16).digest()

    def part(self, begin: int, end: int) -> np.ndarray:
        return self.values[begin:end]


class _InFile:
    """Numbers of one channel or clock in a temporary file, with a digest of all of them."""

    def __init__(self) -> None:
        self.kept, self.count, self._digest = Kept(), 0, hashlib.blake2b(digest_size=16)
        self.digest = self._digest.digest

    def append(self, values: np.ndarray) -> None:
        data = np.ascontiguousarray(values, dtype="<f8").tobytes()
        self.kept.append(data)
        self._digest.update(data)
        self.count += len(values)

    def part(self, begin: int, end: int) -> np.ndarray:
        # Beside a longer group, a range may begin beyond the end.
        count = max(min(end, self.count) - begin, 0)
        return np.frombuffer(self.kept.read(8 * count, 8 * begin), dtype="<f8")


_Column = _InMemory | _InFile


@dataclass(frozen=True)
class SpooledGroup:
    clock: str  # name of the time column
    channels: tuple[Channel, ...]  # the channels, without samples
    count: int  # number of samples of each
    _time: _Column
    _values: tuple[_Column, ...]

    def time(self, begin: int, end: int) -> np.ndarray:
        return self._time.part(begin, end)

    def values(self, begin: int, end: int) -> list[np.ndarray]:
        return [column.part(begin, end) for column in self._values]

    def column(self, place: int) -> np.ndarray:
        return self._values[place].part(0, self.count)

    def rows(self) -> Iterator[tuple[np.ndarray, list[np.ndarray]]]:
        """(time [s], values of every channel), some rows at a time; one empty pair without rows."""
        for begin in range(0, max(self.count, 1), ROWS):
            yield self.time(begin, begin + ROWS), self.values(begin, begin + ROWS)


class Spool:
    """Collects a recording piece by piece, and groups its channels by their clocks."""

    def __init__(self) -> None:
        self._channels: dict[str, Channel] = {}
        self._times: dict[str, _Column] = {}
        self._values: dict[str, _Column] = {}
        self._files: dict[str, tuple[_InFile, _InFile]] = {}
        self.metadata: dict[str, Any] = {}

    @classmethod
    def of(cls, recording: Recording) -> Spool:
        spool, times = cls(), {id(each.time): _InMemory(each.time) for each in recording.channels.values()}
        spool.metadata |= recording.metadata
        for name, channel in recording.channels.items():
            spool._channels[name] = channel
            spool._times[name], spool._values[name] = times[id(channel.time)], _InMemory(channel.values)
        return spool

    def add(self, piece: Recording) -> None:
        self.metadata |= piece.metadata
        try:
            for channel in piece.channels.values():
                if channel.name not in self._channels:
                    self._channels[channel.name] = channel.sliced(0.0, 0.0)
                    self._files[channel.name] = _InFile(), _InFile()
                    self._times[channel.name], self._values[channel.name] = self._files[channel.name]
                time, values = self._files[channel.name]
                time.append(channel.time)
                values.append(channel.values)
                first = self._channels[channel.name]
                self._channels[channel.name] = first.noted(*channel.note.split("; "))
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise OutputError(
                f"the temporary folder cannot take the recording: {reason}; set TMPDIR to one with room"
            ) from None

    def groups(self) -> tuple[SpooledGroup, ...]:
        if not self._channels:
            raise OutputError(
                "the recording has no channels, so there is nothing to write; choose channels that it has"
            )
        # Equal stamps make a group, compared by a digest: in files, every channel has stamps of its own.
        by_clock: dict[tuple[int, bytes], list[str]] = {}
        for name, time in self._times.items():
            by_clock.setdefault((time.count, time.digest()), []).append(name)
        taken = set(self._channels)
        found = []
        for names in by_clock.values():
            choices = ("time", *(f"time.{number}" for number in range(2, len(taken) + 3)))
            clock = next(name for name in choices if name not in taken)
            taken.add(clock)
            channels = tuple(self._channels[name] for name in names)
            columns = tuple(self._values[name] for name in names)
            found.append(SpooledGroup(clock, channels, self._times[names[0]].count, self._times[names[0]], columns))
        return tuple(found)

    @property
    def channels(self) -> Mapping[str, Channel]:
        return self._channels

    def description(self, found: tuple[SpooledGroup, ...]) -> dict[str, Any]:
        origin = self.metadata.get("origin", 0.0)
        metadata = {key: value for key, value in self.metadata.items() if key not in _OF_READING}
        return {
            "layout": 1,
            "origin": float(origin) if isinstance(origin, int | float) else 0.0,
            "clocks": [{"time": each.clock, "channels": [item.name for item in each.channels]} for each in found],
            "channels": {
                name: {"unit": each.unit, "source": each.source, "note": each.note}
                for name, each in self._channels.items()
            },
            "metadata": plain(metadata),
        }


@dataclass(frozen=True)
class FromSpool:
    """Writer of recordings in memory, by a function that writes a spool and returns what its format cannot hold."""

    spooled: Callable[[Spool, str | Path], tuple[str, ...]]

    def __call__(self, recording: Recording, path: str | Path) -> None:
        self.spooled(Spool.of(recording), path)
