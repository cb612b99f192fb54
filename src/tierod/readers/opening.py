"""Opening a file: which reader its content needs, and the database that a CAN log needs besides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tierod.errors import InputError, nearest
from tierod.readers.channel_map import GUESSED, TimeEntry, maps_beside
from tierod.readers.detect import Kind, detect
from tierod.readers.frames import Frames, identifier_text, taken
from tierod.readers.source import Source
from tierod.timestamps import order

Paths = str | Path | Sequence[str | Path] | None

TOLD = 0.005
"""Frames that come later than this are told of, though they can be put in order [s]: drivers of buses are less late."""


def open_source(path: str | Path, dbc: Paths = None, time: TimeEntry | None = None) -> tuple[Source, Kind]:
    """The columns of a file, and what kind of file it is; nothing is loaded that the listing does not need.

    Args:
        path: of the file
        dbc: databases of a CAN log
        time: which column of a table is the time, and in which unit; MDF files and CAN logs tell their time themselves

    Raises:
        InputError: the file or the database cannot be used
        MissingExtra: the library for this format is not installed
    """
    path = Path(path)
    kind = detect(path)
    if kind.data is not None and kind.name in ("mdf", "parquet", "mat"):
        if kind.piped:
            raise InputError(f"{path} is a pipe, through which only text and CAN logs can come; give the file itself")
        raise InputError(f"{path} is packed, which only text and CAN logs may be; unpack it first: gunzip -k {path}")
    if kind.name in _TABLES:
        opened: Source | Frames = _TABLES[kind.name](path, kind, time or GUESSED)
    else:
        opened = _OPENERS[kind.name](path, kind)
    if isinstance(opened, Source):
        for entry in [dbc] if isinstance(dbc, str | Path) else dbc or ():
            if not shipped(entry, ".dbc").is_file():
                raise InputError(f"there is no CAN database {entry}; check the path, or leave it out for this file")
        return opened, kind
    return _decoded(path, opened, dbc, kind), kind


def _decoded(path: Path, frames: Frames, dbc: Paths, kind: Kind) -> Source:
    from tierod.readers.dbc import bus_source, load_databases

    if dbc is None or (not isinstance(dbc, str | Path) and not dbc):
        ids = np.unique(frames.identifier)
        some = ", ".join(identifier_text(int(identifier)) for identifier in ids[:6]) + ", ..." * (len(ids) > 6)
        raise InputError(
            f"{path} holds {len(frames)} CAN frames of {len(ids)} identifiers ({some}); "
            "which signals they carry stands in a DBC file: give it with dbc= (--dbc)"
        )
    paths = [dbc] if isinstance(dbc, str | Path) else list(dbc)
    put = order(frames.time, f"the log {path.name}")
    if put.index is not None:
        frames = taken(frames, put.index)
    if put.behind > TOLD:
        late = (
            f"frames of the log come up to {put.behind:.2g} s late and were put in order: was a clock set back there?"
        )
        frames = replace(frames, notes=(*frames.notes, late))
    found = [shipped(entry, ".dbc") for entry in paths]
    names = {"format": kind.name, "dbc": tuple(str(entry) for entry in paths)}
    return replace(bus_source(frames, load_databases(found), names), maps=maps_beside(found))


def shipped(name: str | Path, ending: str) -> Path:
    """A file as given, or the one that tierod ships where a bare name is given; a folder of that name is no file."""
    path = Path(name)
    if path.is_file() or path.suffix or len(path.parts) > 1:
        return path
    folder = Path(__file__).resolve().parent.parent / "vehicles"
    shipped = {file.name.removesuffix(ending): file for file in folder.glob(f"*{ending}")}
    if path.name not in shipped:
        raise InputError(
            f"there is no file {path}, and tierod ships no '{path.name}{ending}'{nearest(path.name, shipped)}"
        )
    return shipped[path.name]


def _open_mdf(path: Path, kind: Kind) -> Source | Frames:
    from tierod.readers.mdf import open_mdf

    return open_mdf(path)


def _open_parquet(path: Path, kind: Kind, time: TimeEntry) -> Source:
    from tierod.readers.parquet import open_parquet

    return open_parquet(path, time)


def _open_mat(path: Path, kind: Kind, time: TimeEntry) -> Source:
    from tierod.readers.mat import open_mat

    return open_mat(path, time)


def _open_csv(path: Path, kind: Kind, time: TimeEntry) -> Source:
    from tierod.readers.csv import open_csv

    return open_csv(path, _data(path, kind), time)


def _open_candump(path: Path, kind: Kind) -> Frames:
    from tierod.readers.candump import read_frames

    return _named(path, lambda: read_frames(_data(path, kind)))


def _open_vendor(path: Path, kind: Kind) -> Frames:
    from tierod.readers.vendor_can import read_frames

    return _named(path, lambda: read_frames(_data(path, kind), kind.name))


_TABLES: dict[str, Callable[[Path, Kind, TimeEntry], Source]] = {
    "parquet": _open_parquet,
    "mat": _open_mat,
    "csv": _open_csv,
}

_OPENERS: dict[str, Callable[[Path, Kind], Source | Frames]] = {
    "mdf": _open_mdf,
    "candump": _open_candump,
    "asc": _open_vendor,
    "blf": _open_vendor,
    "trc": _open_vendor,
}


def _data(path: Path, kind: Kind) -> bytes:
    return path.read_bytes() if kind.data is None else kind.data


def _named(path: Path, work: Callable[[], Frames]) -> Frames:
    try:
        return work()
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
