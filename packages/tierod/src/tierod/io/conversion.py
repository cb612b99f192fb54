"""Conversion of recordings from any format that is read to any that is written, piece by piece."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tierod.core.recording import Recording
from tierod.io.readers.mapping import Plan, as_recorded
from tierod.io.readers.opening import open_parts
from tierod.io.readers.reading import SHARE_READ, Reading, loaded_map, planned
from tierod.io.readers.source import Source
from tierod.io.writers import WRITERS, require_writable, write
from tierod.io.writers.spool import FromSpool, Spool

SLICE = 60.0  # Length of the slice of a recording that is in memory at once [s]


@dataclass(frozen=True)
class Converted:
    channels: int  # number of channels
    samples: int  # number of samples of all channels
    seconds: float  # time from the first to the last sample [s]
    lost: tuple[str, ...]  # sentences on what the format cannot hold
    # warnings of the reader, notes on samples that were sorted, and on columns that were left out
    warnings: tuple[str, ...]


def convert(
    paths: Sequence[Path],
    output: Path,
    *,
    dbc: Any = None,
    channel_map: Any = None,
    canonical: bool = False,
    progress: Callable[[float], None] = lambda share: None,
) -> Converted:
    """Convert recordings to another format; several are parts of one drive.

    Args:
        output: path of the new file, whose ending selects the format
        channel_map: map of columns to canonical signals; without one, columns keep their names and units
        canonical: whether columns with a known name become canonical signals in SI units even without a map
        progress: called with the share done, 0 to 1

    Raises:
        InputError: a recording cannot be read, or they are no parts of one drive
        OutputError: the ending is not known, or the file cannot be written
        MissingExtra: a library for a format is not installed
    """
    require_writable(output)
    used = loaded_map(channel_map)
    source, kind = open_parts(paths, dbc, used.time if used else None)
    plan = planned(paths[0], source, used, None) if canonical or used is not None else as_found(source)
    seen = _Seen()
    lost = _written(seen.of(Reading(paths[0], source, kind, plan).slices(SLICE), progress), output)
    empty = [pick.name for pick in plan.picks if pick.name not in seen.names]
    said = (*seen.warnings, *seen.repaired(), *_left_out(source.texts, "they hold text"),
            *_left_out(empty, "they gave no numbers"))  # fmt: skip
    return Converted(len(seen.names), seen.samples, seen.last - seen.first, lost, said)


def _written(pieces: Iterable[Recording], path: Path) -> tuple[str, ...]:
    """Write consecutive pieces, in which a channel may be missing; returns what the format cannot hold."""
    spool = Spool()
    for piece in pieces:
        spool.add(piece)
    writer = WRITERS[path.suffix.lower().removeprefix(".")]
    if isinstance(writer.write, FromSpool):
        return writer.write.spooled(spool, path)
    # The writer of another package takes a recording in memory only.
    channels = {}
    for group in spool.groups():
        time, values = group.time(0, group.count), group.values(0, group.count)
        for channel, part in zip(group.channels, values, strict=True):
            channels[channel.name] = replace(channel, time=time, values=part)
    write(Recording(channels, spool.metadata), path)
    return (f"{writer.title} is written by another package; what the file keeps depends on its writer",)


NAMED = 5  # Number of columns that a sentence names; the others are counted


def _left_out(names: Sequence[str], why: str) -> tuple[str, ...]:
    if not names:
        return ()
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return (f"not converted, since {why}: {', '.join(names[:NAMED])}{more}",)


def as_found(source: Source) -> Plan:
    return Plan(tuple(as_recorded(column) for column in source.columns))


class _Seen:
    def __init__(self) -> None:
        self.names: set[str] = set()
        self.samples, self.first, self.last = 0, float("inf"), float("-inf")
        self.warnings: tuple[str, ...] = ()
        self._notes: dict[str, str] = {}

    def repaired(self) -> tuple[str, ...]:
        counts = Counter(note for text in self._notes.values() for note in text.split("; ") if note)
        return tuple(f"{note} ({count} {'channel' if count == 1 else 'channels'})" for note, count in counts.items())

    def of(self, pieces: Iterator[Recording], progress: Callable[[float], None]) -> Iterator[Recording]:
        for piece in pieces:
            self.names |= set(piece.names)
            self.samples += sum(len(each.time) for each in piece.channels.values())
            self._notes |= {each.name: each.note for each in piece.channels.values() if each.note}
            begin, end = piece.span
            self.first, self.last, self.warnings = min(self.first, begin), max(self.last, end), piece.warnings
            yield piece
            progress(float(piece.metadata.get(SHARE_READ, 1.0)))
