"""Reading a recording slice by slice, so that it need not fit into memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from tierod.derive import RECIPES, complete
from tierod.errors import InputError
from tierod.readers.channel_map import ChannelMap
from tierod.readers.chunks import regrouped
from tierod.readers.detect import Kind
from tierod.readers.making import apply, shifted
from tierod.readers.mapping import Plan
from tierod.readers.opening import Paths, open_source
from tierod.readers.source import Source
from tierod.readers.whole import loaded_map, metadata_of, origin_of, planned, read_source, require_samples
from tierod.recording import Channel, Recording, checked_together

SHARE_READ = "share_read"
"""Metadata of a slice: how much of the file had been read when it was given out, 0 to 1."""


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
    channel_map = loaded_map(channel_map)
    source, kind = open_source(path, dbc, channel_map.time if channel_map else None)
    if source.pieces is None:
        whole = read_source(path, source, kind, channel_map, names)
        first, last = whole.span
        for slice_ in regrouped([list(whole.channels.values())], seconds):
            part = Recording(slice_, whole.metadata)
            share = (part.span[1] - first) / max(last - first, 1e-9)
            yield Recording(slice_, {**whole.metadata, SHARE_READ: min(share, 1.0)})
        return
    made = planned(path, source, channel_map, names)
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
                origin = origin_of(channels)
            rows += max((len(channel.time) for channel in channels), default=0)
            yield checked_together(shifted(channels, origin) if origin else channels)

    past: Recording | None = None
    for slice_ in regrouped(pieces(), seconds):
        share = {SHARE_READ: min(rows / source.rows, 1.0)} if source.rows else {}
        recording = Recording(slice_, metadata_of(path, source, made, origin or 0.0) | share)
        recording = recording.warned(kind.warning, *source.warnings, *made.warnings, *doubts)
        yield recording if names is None else _completed(recording, past, names)
        past = recording
    if past is None:
        require_samples(path, [])


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
