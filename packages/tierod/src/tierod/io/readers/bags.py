"""Bags and MCAP files: a reader in a separate process lists their columns and delivers them piece by piece."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.formats import description_in, require_library
from tierod.io.readers import bags_child
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.reader_process import ReaderProcess
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with

_TEXTS = ("name", "unit", "title")


def open_bag(path: Path, time: TimeEntry = GUESSED) -> Source:
    """A ROS 1 bag, a ROS 2 bag (its folder or one .db3 file), or an MCAP file.

    Every number in a message becomes a column "topic.field"; the time is that at which the message was logged,
    or the field that the user names, such as header.stamp, in messages that have it.
    """
    for library in ("rosbags", "mcap"):
        require_library(library, "ros", "reading a bag or MCAP file")
    process = ReaderProcess(path, bags_child, "the decoder", "a bag or MCAP file")
    about, _ = process.ask({})
    try:
        written = _written(about["metadata"])
        columns = {_name(column, written): column for column in map(_column, about["columns"])}
        notes = [str(each)[:300] for each in about["notes"]]
        texts = tuple(str(each)[:400] for each in about["texts"])
        origin = float(about["origin"])
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{path} is damaged and cannot be read as a bag; record or copy it again") from None
    if not columns:
        why = f": {'; '.join(notes[:3])}" if notes else ""
        raise InputError(f"{path} holds no message with numbers{why}; record topics of sensors, or convert them")
    lanes_given, clock = itertools.count(), time.column or ""

    def lanes(names: Sequence[str]) -> list[Lane]:
        return [_lane(process, next(lanes_given), {name: columns[name] for name in names}, notes, (written, clock))]

    metadata = {**written.get("metadata", {}), "format": "bag" if path.suffix.lower() != ".mcap" else "MCAP"}
    listed = tuple(replace(column, name=name, qualified=name != column.title) for name, column in columns.items())
    return Source(listed, lanes, metadata, origin, (), lambda: tuple(dict.fromkeys(notes)), texts=texts)


def _column(each: dict[str, Any]) -> Column:
    name, unit, title = (str(each[key])[:400] for key in _TEXTS)
    return Column(name, unit, title, True)


def _written(metadata: dict[str, str]) -> dict[str, Any]:
    """Metadata that tierod wrote beside the messages; empty where another program wrote the file, or it is damaged."""
    try:
        return description_in(metadata["description"])
    except (KeyError, ValueError, TypeError):
        return {}


def _name(column: Column, written: dict[str, Any]) -> str:
    return column.title if column.title in written.get("channels", {}) else column.name


def _lane(
    process: ReaderProcess,
    number: int,
    columns: Mapping[str, Column],
    notes: list[str],
    given: tuple[dict[str, Any], str],
) -> Lane:
    """The wanted columns with their descriptions by tierod, timed by the field that the user names ("": by the log)."""
    described, names = given[0].get("channels", {}), list(columns)
    request = {"lane": number, "clock": given[1], "names": [column.name for column in columns.values()]}
    for about, arrays in process.answers(request):
        notes += [str(note)[:300] for note in about.get("notes", [])]
        channels = []
        for clock, members in enumerate(about.get("clocks", [])):
            time = arrays.get(f"t{clock}", np.empty(0))
            for place in members:
                name, each = names[place], columns[names[place]]
                kept = described.get(name, {})
                origin = (kept.get("source", each.name), kept.get("note", ""))
                channels.append(Channel(name, time, arrays.get(str(place), np.empty(0)), each.unit, *origin))
        yield Piece(channels, float(about.get("share", 1.0)))


ROS1 = Format(
    "ros1", "ROS 1 bag (.bag)", (".bag",), lambda content, time: open_bag(content.path, time), begins_with(b"#ROSBAG"),
    whole=True,
)  # fmt: skip
ROS2 = Format(
    "ros2", "ROS 2 bag (its folder, or .db3)", (".db3",), lambda content, time: open_bag(content.path, time),
    begins_with(b"SQLite format 3"), whole=True,
)  # fmt: skip
MCAP = Format(
    "mcap", "MCAP (.mcap)", (".mcap",), lambda content, time: open_bag(content.path, time), begins_with(b"\x89MCAP"),
    whole=True,
)  # fmt: skip
