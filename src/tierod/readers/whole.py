"""Reading a recording whole: the plan of its channels, and what is told of it as a whole."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.derive import complete
from tierod.errors import InputError
from tierod.readers.channel_map import ChannelMap, load_channel_map, load_maps_beside
from tierod.readers.detect import Kind
from tierod.readers.making import apply, shifted
from tierod.readers.mapping import Plan, plan
from tierod.readers.opening import Paths, open_source, shipped
from tierod.readers.source import Source
from tierod.recording import Channel, Recording, checked_together
from tierod.timestamps import CALENDAR


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
    channel_map = loaded_map(channel_map)
    return read_source(path, *open_source(path, dbc, channel_map.time if channel_map else None), channel_map, names)


def loaded_map(channel_map: str | Path | ChannelMap | None) -> ChannelMap | None:
    """The channel map of a path or of a name that is shipped.

    Raises:
        InputError: it cannot be read
    """
    if isinstance(channel_map, str | Path):
        return load_channel_map(shipped(channel_map, ".channels.toml"))
    return channel_map


def read_source(
    path: str | Path, source: Source, kind: Kind, channel_map: ChannelMap | None, names: tuple[str, ...] | None
) -> Recording:
    """The recording in an opened file; arguments and errors as for `read`."""
    made = planned(path, source, channel_map, names)
    channels, doubts = apply(made, source.load(made.columns))
    require_samples(path, channels)
    origin = origin_of(channels) if not source.origin else 0.0
    channels = checked_together(shifted(channels, origin) if origin else channels)
    recording = Recording({channel.name: channel for channel in channels}, metadata_of(path, source, made, origin))
    recording = recording.warned(kind.warning, *source.warnings, *made.warnings, *doubts)
    return recording if names is None else complete(recording, names)


def planned(path: str | Path, source: Source, channel_map: ChannelMap | None, names: tuple[str, ...] | None) -> Plan:
    """Which columns of an opened file become which channels.

    Raises:
        InputError: the channel map does not fit, or the file holds none of the named signals
    """
    if channel_map is None and source.maps:
        channel_map = load_maps_beside(source.maps)
    made = plan(source.columns, channel_map, names, source.silent)
    if not made.picks and source.silent:
        raise InputError(
            f"{path}: no message with a wanted signal came on the bus ({', '.join(source.silent[:4])}, ...); record "
            "them, or give DBC and channel map of this bus"
        )
    if not made.picks:
        has = ", ".join(f"'{column.name}'" for column in source.columns[:12])
        more = f" and {len(source.columns) - 12} more" if len(source.columns) > 12 else ""
        raise InputError(f"{path} holds none of {', '.join(names or ())}; it holds {has}{more}: write a channel map")
    return made


def require_samples(path: str | Path, channels: Sequence[Channel]) -> None:
    """Stop where nothing was recorded.

    Raises:
        InputError: no channel holds a sample
    """
    if not any(len(channel.time) for channel in channels):
        raise InputError(f"{path} holds no samples of the wanted channels; check that the file is whole")


def origin_of(channels: Sequence[Channel]) -> float:
    """The first stamp of all where stamps are calendar times, else 0."""
    stamps = [float(np.nanmin(channel.time)) for channel in channels if np.isfinite(channel.time).any()]
    return min(stamps) if stamps and min(stamps) > CALENDAR else 0.0


def metadata_of(path: str | Path, source: Source, made: Plan, origin: float) -> dict[str, Any]:
    """What is told of a recording as a whole.

    Args:
        path, source, made: the file, opened, and what becomes of its columns
        origin: calendar time [s] of the stamp zero, where the source tells none
    """
    told = {"channel_map": made.channel_map} if made.channel_map else {}
    return {**source.metadata, **told, "path": str(path), "origin": source.origin or origin}
