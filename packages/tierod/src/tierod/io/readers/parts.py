"""Several files of one drive as one recording: joined by time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tierod.core.errors import InputError
from tierod.core.timestamps import CALENDAR, LATE
from tierod.io.readers.chunks import slices
from tierod.io.readers.limits import Allowance
from tierod.io.readers.making import shifted
from tierod.io.readers.source import Column, Lane, Piece, Source

STRETCH = 10.0  # Length of a stretch of a part that is read at once [s]


@dataclass(frozen=True)
class Part:
    """One file of a drive: its path, the opened file, and the time of its first sample [s]."""

    path: Path
    source: Source
    begin: float


def joined_source(opened: Sequence[tuple[Path, Source]]) -> Source:
    """The files as one, in the order of their time, whatever the order in which they are given.

    Args:
        opened: path and source of every file; a column may be missing in some of them
    """
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
