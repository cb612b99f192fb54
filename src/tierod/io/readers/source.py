"""What every reader of a format gives: the columns of a file, and the samples of some of them piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.recording import Channel


@dataclass(frozen=True)
class Column:
    """One column of a file.

    Args:
        name: in the file; unique
        unit: as the file writes it; "" where it says none
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
        warnings: what a reader of results must know about the file
        found: what came to light while the lanes were read
        size: bytes that the file takes where it lies
        maps: channel maps that lie beside the databases of a bus log
        silent: columns that the databases of a bus log tell of, and that never came in it
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
