"""What every reader of a format gives: the columns of a file, and how to load some of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tierod.recording import Channel


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


@dataclass(frozen=True)
class Source:
    """An opened file.

    Args:
        columns: what it holds
        load: the named columns as channels under their names in the file, in the file's units
        metadata: format, start time, bus, comments
        origin: calendar time [s] of the stamp zero, where the loaded stamps count from there
        warnings: what a reader of results must know about the file
        pieces: the named columns bit by bit in the order of time, for files that need not fit into memory
        rows: of the longest column, all pieces together
        maps: channel maps that lie beside the databases of a bus log
        silent: columns that the databases of a bus log tell of, and that never came in it
    """

    columns: tuple[Column, ...]
    load: Callable[[Sequence[str]], list[Channel]]
    metadata: dict[str, Any] = field(default_factory=dict)
    origin: float = 0.0
    warnings: tuple[str, ...] = ()
    pieces: Callable[[Sequence[str]], Iterator[list[Channel]]] | None = None
    rows: int = 0
    maps: tuple[Path, ...] = ()
    silent: tuple[str, ...] = ()
