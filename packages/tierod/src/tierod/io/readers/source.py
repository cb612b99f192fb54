"""File formats and opened files: the columns of a file, and the samples of some of them piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.recording import Channel
from tierod.io.readers.channel_map import TimeEntry
from tierod.io.readers.content import Content
from tierod.io.readers.frames import Log


@dataclass(frozen=True)
class Column:
    name: str  # name in the file; unique
    unit: str = ""  # as the file writes it; "" where it has none
    # the name without a unit in it, by which a canonical signal is guessed; the name itself where not given
    title: str = ""
    # whether the title is the last part of a name that begins with a message, group or structure
    qualified: bool = False


class Piece(NamedTuple):
    channels: list[Channel]  # as recorded, under their names in the file; those with common time stamps share the array
    share: float = 0.0  # share of the file that has been read so far, 0 to 1


# Channels that a file holds side by side, piece by piece; the lanes of a file are read independently
Lane = Iterator[Piece]


@dataclass(frozen=True)
class Source:
    columns: tuple[Column, ...]  # its columns
    # gives the named columns, in the file's units, from beginning to end; called again for every reading
    lanes: Callable[[Sequence[str]], list[Lane]]
    metadata: dict[str, Any] = field(default_factory=dict)  # format, start time, bus, comments
    origin: float = 0.0  # calendar time [s] of the stamp zero, where the loaded stamps count from there
    warnings: tuple[str, ...] = ()  # notices about the file for a reader of results
    found: Callable[[], tuple[str, ...]] = tuple  # gives warnings that arose while the lanes were read
    size: int = 0  # size of the stored file [bytes]
    maps: tuple[Path, ...] = ()  # channel maps beside the databases of a bus log
    silent: tuple[str, ...] = ()  # columns that the databases of a bus log describe, and of which it has no message
    texts: tuple[str, ...] = ()  # names of columns without numbers, such as text, which cannot be read


def source_of(channels: Sequence[Channel], metadata: Mapping[str, object] | None = None) -> Source:
    """An opened file whose channels are in memory, for a format whose files are small."""
    by_name = {channel.name: channel for channel in channels}

    def lanes(names: Sequence[str]) -> list[Lane]:
        return [iter([Piece([by_name[name]], 1.0)]) for name in names]

    return Source(tuple(Column(each.name, each.unit) for each in channels), lanes, dict(metadata or {}))


@dataclass(frozen=True)
class Format:
    name: str  # short name, for messages and metadata
    title: str  # name for users, with the usual endings
    endings: tuple[str, ...]  # endings of file names, in lower case, with their point
    # gives the columns of a file, or the frames of a CAN log; takes its content and its time column
    open: Callable[[Content, TimeEntry], Source | Log]
    # whether a file with this beginning (64 kB) is of this format; takes its ending too, "" without one
    recognises: Callable[[bytes, str], bool]
    text: bool = False  # whether a text is of this format by its ending alone, where no format recognises its beginning
    whole: bool = False  # whether a file must lie on the disk unpacked: neither gzip nor a pipe


def text_begin(head: bytes) -> bytes:
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()


def begins_with(*beginnings: bytes) -> Callable[[bytes, str], bool]:
    return lambda head, ending: head.startswith(beginnings)
