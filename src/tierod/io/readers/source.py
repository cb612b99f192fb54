"""A file format and an opened file: its columns, and the samples of some of them piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.recording import Channel
from tierod.io.readers.channel_map import TimeEntry
from tierod.io.readers.content import Content
from tierod.io.readers.log import Log


@dataclass(frozen=True)
class Column:
    """One column of a file.

    Args:
        name: in the file; unique
        unit: as the file writes it; "" where it has none
        title: the name without a unit in it, by which a canonical signal is guessed; the name itself where not given
        qualified: whether the title is the last part of a name that begins with a message, group or structure
    """

    name: str
    unit: str = ""
    title: str = ""
    qualified: bool = False


class Piece(NamedTuple):
    """Some channels over a stretch of the file.

    Args:
        channels: as recorded, under their names in the file; those with common time stamps share the array
        share: of the file that has been read up to here, 0 to 1
    """

    channels: list[Channel]
    share: float = 0.0


Lane = Iterator[Piece]
"""Channels that a file holds side by side, piece by piece; several lanes of a file run through it independently."""


@dataclass(frozen=True)
class Source:
    """An opened file.

    Args:
        columns: what it holds
        lanes: the named columns, in the file's units, from the beginning to the end; called anew for every reading
        metadata: format, start time, bus, comments
        origin: calendar time [s] of the stamp zero, where the loaded stamps count from there
        warnings: notices about the file for a reader of results
        found: what came to light while the lanes were read
        size: bytes that the file takes where it lies
        maps: channel maps that lie beside the databases of a bus log
        silent: columns that the databases of a bus log describe, and that never came in it
        texts: names of columns that hold text, or else no numbers, and cannot be read
    """

    columns: tuple[Column, ...]
    lanes: Callable[[Sequence[str]], list[Lane]]
    metadata: dict[str, Any] = field(default_factory=dict)
    origin: float = 0.0
    warnings: tuple[str, ...] = ()
    found: Callable[[], tuple[str, ...]] = tuple
    size: int = 0
    maps: tuple[Path, ...] = ()
    silent: tuple[str, ...] = ()
    texts: tuple[str, ...] = ()


def source_of(channels: Sequence[Channel], metadata: Mapping[str, object] | None = None) -> Source:
    """An opened file whose channels are in memory, for a format whose files are small.

    Args:
        channels: as recorded, under their names and with the units of the file; "" where it gives none
        metadata: of the recording
    """
    by_name = {channel.name: channel for channel in channels}

    def lanes(names: Sequence[str]) -> list[Lane]:
        return [iter([Piece([by_name[name]], 1.0)]) for name in names]

    return Source(tuple(Column(each.name, each.unit) for each in channels), lanes, dict(metadata or {}))


@dataclass(frozen=True)
class Format:
    """A file format that can be read.

    Args:
        name: short, as in messages and metadata
        title: for people, with the endings that are usual
        endings: of file names, in lower case, with their point
        open: gives the columns of a file, or the frames of a CAN log; takes its content and which column is the time
        recognises: whether a file that begins so (64 kB) is of this format; takes its ending too, "" without one
        text: whether it is taken by the ending too, where no format recognises the beginning of a text
        whole: whether a file must lie on the disk unpacked: neither gzip nor a pipe
    """

    name: str
    title: str
    endings: tuple[str, ...]
    open: Callable[[Content, TimeEntry], Source | Log]
    recognises: Callable[[bytes, str], bool]
    text: bool = False
    whole: bool = False


def text_begin(head: bytes) -> bytes:
    """The beginning of a text without byte order mark and white space in front."""
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()


def begins_with(*beginnings: bytes) -> Callable[[bytes, str], bool]:
    """A test of a format by the first bytes of its files.

    Args:
        beginnings: any of which they have
    """
    return lambda head, ending: head.startswith(beginnings)
