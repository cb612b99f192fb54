"""Reading recordings: one function for every format, chosen by the content of the file.

recording = read("drive.mf4")
recording = read("can.log", dbc="car.dbc", channel_map="car.channels.toml")
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tierod.derive import RECIPES, complete
from tierod.errors import InputError, nearest
from tierod.readers.channel_map import (
    ChannelMap,
    load_channel_map,
    load_maps_beside,
    maps_beside,
    parse_channel_map,
)
from tierod.readers.chunks import regrouped
from tierod.readers.detect import Kind, detect
from tierod.readers.frames import Frames, identifier_text, taken
from tierod.readers.mapping import Plan, apply, plan, shifted
from tierod.readers.source import Column, Source
from tierod.recording import Channel, Recording, checked_together
from tierod.timestamps import CALENDAR, order

__all__ = [
    "ChannelMap",
    "Column",
    "Frames",
    "Source",
    "load_channel_map",
    "open_chunks",
    "open_source",
    "parse_channel_map",
    "read",
]

SHARE_READ = "share_read"
"""Metadata of a slice: how much of the file had been read when it was given out, 0 to 1."""

Paths = str | Path | Sequence[str | Path] | None


def read(
    path: str | Path,
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    names: Iterable[str] | None = None,
) -> Recording:
    """The recording in a file, with canonical names and in SI units.

    Args:
        path: MF4, MDF, Parquet, CSV, MATLAB 5, candump -L, ASC, BLF or TRC; text may be packed with gzip
        dbc: database of a CAN log, or several; a bare name such as "rav4" means the one that tierod ships
        channel_map: TOML file that says which column is which signal; a bare name means the one that tierod ships;
            where not given, "car.channels.toml" beside "car.dbc" is used if it is there (metadata "channel_map")
        names: the signals (or columns) wanted, all where not given; signals that the file lacks are derived where
            tierod.derive has a recipe, and are absent otherwise

    Returns:
        time counts from the first stamp where the file has calendar time (metadata "origin" keeps it);
        what was guessed, repaired or lost stands in `warnings` and in the notes of the channels

    Raises:
        InputError: the file, the database or the map cannot be used; the message says what to do
        MissingExtra: the library for this format is not installed
    """
    names = None if names is None else tuple(names)
    return _whole(path, *open_source(path, dbc), channel_map, names)


def _whole(path: str | Path, source: Source, kind: Kind, channel_map: Any, names: tuple[str, ...] | None) -> Recording:
    made = _plan(path, source, channel_map, names)
    channels, doubts = apply(made, source.load(made.columns))
    _require_samples(path, channels)
    origin = _origin(channels) if not source.origin else 0.0
    channels = checked_together(shifted(channels, origin) if origin else channels)
    recording = Recording({channel.name: channel for channel in channels}, _metadata(path, source, made, origin))
    recording = recording.warned(kind.warning, *source.warnings, *made.warnings, *doubts)
    return recording if names is None else complete(recording, names)


def open_chunks(
    path: str | Path,
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    names: Iterable[str] | None = None,
    seconds: float = 600.0,
) -> Iterator[Recording]:
    """The recording in a file as consecutive slices, so that a long one need not fit into memory.

    Parquet is read row group by row group; other formats are read whole and sliced.

    Args:
        path, dbc, channel_map, names: as for `read`
        seconds: length of the slices [s]; ten minutes of ten channels at 100 Hz are 5 MB

    Raises:
        InputError: as for `read`, or slices that are not positive
    """
    if not seconds > 0.0:
        raise InputError(f"slices need a positive length, not {seconds} s")
    names = None if names is None else tuple(names)
    source, kind = open_source(path, dbc)
    if source.pieces is None:
        whole = _whole(path, source, kind, channel_map, names)
        first, last = whole.span
        for slice_ in regrouped([list(whole.channels.values())], seconds):
            part = Recording(slice_, whole.metadata)
            share = (part.span[1] - first) / max(last - first, 1e-9)
            yield Recording(slice_, {**whole.metadata, SHARE_READ: min(share, 1.0)})
        return
    made = _plan(path, source, channel_map, names)
    yield from _streamed(path, source, kind, made, names, seconds)


def _streamed(
    path: str | Path, source: Source, kind: Kind, made: Plan, names: tuple[str, ...] | None, seconds: float
) -> Iterator[Recording]:
    loaded_pieces = source.pieces
    if loaded_pieces is None:
        return
    origin: float | None = 0.0 if source.origin else None
    doubts: dict[str, None] = {}
    rows = 0

    def pieces() -> Iterator[list[Channel]]:
        nonlocal origin, rows
        for loaded in loaded_pieces(made.columns):
            channels, found = apply(made, loaded)
            doubts.update(dict.fromkeys(found))
            if origin is None:
                origin = _origin(channels)
            rows += max((len(channel.time) for channel in channels), default=0)
            yield checked_together(shifted(channels, origin) if origin else channels)

    past: Recording | None = None
    for slice_ in regrouped(pieces(), seconds):
        share = {SHARE_READ: min(rows / source.rows, 1.0)} if source.rows else {}
        recording = Recording(slice_, _metadata(path, source, made, origin or 0.0) | share)
        recording = recording.warned(kind.warning, *source.warnings, *made.warnings, *doubts)
        yield recording if names is None else _completed(recording, past, names)
        past = recording
    if past is None:
        _require_samples(path, [])


def _completed(recording: Recording, past: Recording | None, names: tuple[str, ...]) -> Recording:
    """Derived signals that look back over the edge between two slices."""
    if past is None:
        return complete(recording, names)
    begin = recording.span[0]
    joined = []
    for name, channel in recording.channels.items():
        before = past.channels[name].sliced(begin - max(recipe.memory for recipe in RECIPES.values()), begin)
        time, values = (np.concatenate(pair) for pair in ((before.time, channel.time), (before.values, channel.values)))
        joined.append(Channel(name, time, values, channel.unit, channel.source, channel.note))
    derived = complete(Recording({channel.name: channel for channel in joined}), names).slice(begin)
    new = [channel for name, channel in derived.channels.items() if name not in recording]
    return recording.with_channels(new)


def open_source(path: str | Path, dbc: Paths = None) -> tuple[Source, Kind]:
    """The columns of a file, and what kind of file it is; nothing is loaded that the listing does not need.

    Raises:
        InputError: the file or the database cannot be used
        MissingExtra: the library for this format is not installed
    """
    path = Path(path)
    kind = detect(path)
    if kind.data is not None and kind.name in ("mdf", "parquet", "mat"):
        raise InputError(f"{path} is packed, which only text and CAN logs may be; unpack it first: gunzip -k {path}")
    opened = _OPENERS[kind.name](path, kind)
    if isinstance(opened, Source):
        for entry in [dbc] if isinstance(dbc, str | Path) else dbc or ():
            if not _shipped(entry, ".dbc").exists():
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
    found = [_shipped(entry, ".dbc") for entry in paths]
    names = {"format": kind.name, "dbc": tuple(str(entry) for entry in paths)}
    return replace(bus_source(frames, load_databases(found), names), maps=maps_beside(found))


def _shipped(name: str | Path, ending: str) -> Path:
    """A file as given, or the one that tierod ships where a bare name is given."""
    path = Path(name)
    if path.exists() or path.suffix or len(path.parts) > 1:
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


def _open_parquet(path: Path, kind: Kind) -> Source:
    from tierod.readers.parquet import open_parquet

    return open_parquet(path)


def _open_mat(path: Path, kind: Kind) -> Source:
    from tierod.readers.mat import open_mat

    return open_mat(path)


def _open_csv(path: Path, kind: Kind) -> Source:
    from tierod.readers.csv import open_csv

    return open_csv(path, _data(path, kind))


def _open_candump(path: Path, kind: Kind) -> Frames:
    from tierod.readers.candump import read_frames

    return _named(path, lambda: read_frames(_data(path, kind)))


def _open_vendor(path: Path, kind: Kind) -> Frames:
    from tierod.readers.vendor_can import read_frames

    return _named(path, lambda: read_frames(_data(path, kind), kind.name))


_OPENERS: dict[str, Callable[[Path, Kind], Source | Frames]] = {
    "mdf": _open_mdf,
    "parquet": _open_parquet,
    "mat": _open_mat,
    "csv": _open_csv,
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


def _plan(path: str | Path, source: Source, channel_map: Any, names: tuple[str, ...] | None) -> Plan:
    if isinstance(channel_map, str | Path):
        channel_map = load_channel_map(_shipped(channel_map, ".channels.toml"))
    elif channel_map is None and source.maps:
        channel_map = load_maps_beside(source.maps)
    made = plan(source.columns, channel_map, names)
    if not made.picks:
        has = ", ".join(f"'{column.name}'" for column in source.columns[:12])
        more = f" and {len(source.columns) - 12} more" if len(source.columns) > 12 else ""
        raise InputError(f"{path} holds none of {', '.join(names or ())}; it holds {has}{more}: write a channel map")
    return made


def _require_samples(path: str | Path, channels: Sequence[Channel]) -> None:
    if not any(len(channel.time) for channel in channels):
        raise InputError(f"{path} holds no samples of the wanted channels; check that the file is whole")


def _origin(channels: Sequence[Channel]) -> float:
    """The first stamp of all where stamps are calendar times, else 0."""
    stamps = [float(np.nanmin(channel.time)) for channel in channels if np.isfinite(channel.time).any()]
    return min(stamps) if stamps and min(stamps) > CALENDAR else 0.0


def _metadata(path: str | Path, source: Source, made: Plan, origin: float) -> dict[str, Any]:
    told = {"channel_map": made.channel_map} if made.channel_map else {}
    return {**source.metadata, **told, "path": str(path), "origin": source.origin or origin}
