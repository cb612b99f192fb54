"""Reading of a recording slice by slice or as a whole, in the same way for every format."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.timestamps import CALENDAR
from tierod.io.derive import RECIPES, complete, ingredients
from tierod.io.readers.channel_map import ChannelMap, load_channel_map, load_maps_beside
from tierod.io.readers.chunks import slices
from tierod.io.readers.limits import Allowance
from tierod.io.readers.making import Doubts, made_from, shifted
from tierod.io.readers.mapping import Plan, plan
from tierod.io.readers.opening import Kind, Paths, open_source, shipped
from tierod.io.readers.source import Source

SHARE_READ = "share_read"  # Metadata key of a slice: share of the file that had been read when it was delivered, 0 to 1


# Metadata key of a recording: by signal, a sentence on the column that its channel map names and the file lacks
LACKING = "lacking_columns"


def open_chunks(
    path: str | Path,
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    names: Iterable[str] | None = None,
    seconds: float = 600.0,
) -> Iterator[Recording]:
    """The recording in a file as consecutive slices, so that a long one need not fit into memory.

    Warnings and notes on repairs count from the beginning of the recording: those of the last slice are complete.

    Args:
        path, dbc, channel_map, names: as for `read`
        seconds: length of the slices [s]; ten minutes of ten channels at 100 Hz are 5 MB

    Raises:
        InputError: as for `read`, or the length of the slices is not positive
    """
    if not seconds > 0.0:
        raise InputError(f"slices need a positive length, not {seconds} s")
    names = None if names is None else tuple(names)
    used = loaded_map(channel_map)
    source, kind = open_source(path, dbc, used.time if used else None)
    reading = Reading(path, source, kind, planned(path, source, used, names))
    past: Recording | None = None
    for recording in reading.slices(seconds):
        yield recording if names is None else completed(recording, past, names)
        past = recording


def loaded_map(channel_map: str | Path | ChannelMap | None) -> ChannelMap | None:
    """The channel map at a path, or the shipped one with a name; any other argument unchanged."""
    if isinstance(channel_map, str | Path):
        return load_channel_map(shipped(channel_map, ".channels.toml"))
    return channel_map


def planned(path: str | Path, source: Source, channel_map: ChannelMap | None, names: tuple[str, ...] | None) -> Plan:
    """Plan of the columns of an opened file that become channels.

    Args:
        channel_map: the channel map; where None, the one beside the database is used, if there is one
        names: names of the wanted signals; None for all
    """
    if channel_map is None and source.maps:
        channel_map = load_maps_beside(source.maps)
    try:
        made = plan(source.columns, channel_map, names, source.silent)
    except InputError as error:
        # Among several recordings, the user needs the one that the map or the names do not fit.
        raise InputError(f"{path}: {error}") from None
    if not made.picks and (absent := [made.lacking[name] for name in ingredients(names or ()) if name in made.lacking]):
        raise InputError(f"{path}: {absent[0]} Correct the channel map")
    if not made.picks and source.silent:
        raise InputError(
            f"{path}: no message with a wanted signal was received on the bus ({', '.join(source.silent[:4])}, ...); "
            "record "
            "them, or give DBC and channel map of this bus"
        )
    if not made.picks and not source.columns:
        raise InputError(f"{path} holds no columns of numbers beside the time; export the signals as numbers")
    if not made.picks:
        has = ", ".join(f"'{column.name}'" for column in source.columns[:12])
        more = f" and {len(source.columns) - 12} more" if len(source.columns) > 12 else ""
        raise InputError(f"{path} holds none of {', '.join(names or ())}; it holds {has}{more}: write a channel map")
    return made


@dataclass
class Reading:
    """One pass through an opened file, from its beginning to its end."""

    # the opened file
    path: str | Path
    source: Source
    kind: Kind
    plan: Plan  # plan of the channels
    _origin: float | None = None
    _doubts: Doubts = field(default_factory=Doubts)

    def slices(self, seconds: float) -> Iterator[Recording]:
        """The channels of the plan, slice by slice, without derived signals.

        Args:
            seconds: length of the slices [s]; infinity gives the whole
        """
        lanes = self.source.lanes(self.plan.columns)
        empty = True
        for loaded, share in slices(lanes, seconds, Allowance(self.path, self.source.size)):
            empty = False
            if self._origin is None:
                self._origin = 0.0 if self.source.origin else origin_of(loaded)
            channels = made_from(self.plan, loaded, self._doubts)
            channels = shifted(channels, self._origin) if self._origin else channels
            yield self._recording(channels, share)
        if empty:
            raise InputError(f"{self.path} holds no samples of the wanted channels; check that the file is whole")

    def _recording(self, channels: list[Channel], share: float) -> Recording:
        mapped: dict[str, object] = {"channel_map": self.plan.channel_map} if self.plan.channel_map else {}
        if self.plan.lacking:
            mapped[LACKING] = dict(self.plan.lacking)
        origin = self.source.origin or self._origin
        metadata = {**self.source.metadata, **mapped, "path": str(self.path), "origin": origin, SHARE_READ: share}
        recording = Recording({channel.name: channel for channel in channels}, metadata)
        return recording.warned(
            self.kind.warning,
            *self.source.warnings,
            *self.source.found(),
            *self.plan.warnings,
            *self._doubts.sentences(self.plan),
        )


def origin_of(channels: Iterable[Channel]) -> float:
    """The first stamp of all channels where stamps are calendar times, else 0."""
    stamps = [float(channel.time[0]) for channel in channels if len(channel.time)]
    return min(stamps) if stamps and min(stamps) > CALENDAR else 0.0


def completed(recording: Recording, past: Recording | None, names: tuple[str, ...]) -> Recording:
    """A slice with its derived signals, which also use the end of the slice before it.

    Args:
        past: the slice before it; None for the first
    """
    if past is None:
        return complete(recording, names)
    if not any(name in RECIPES and name not in recording for name in names):
        return recording
    begin = recording.span[0]
    joined = []
    for name, channel in recording.channels.items():
        if name not in past.channels:  # on a live bus a message may begin later than others
            joined.append(channel)
            continue
        before = past.channels[name].sliced(begin - max(recipe.memory for recipe in RECIPES.values()), begin)
        time, values = (np.concatenate(pair) for pair in ((before.time, channel.time), (before.values, channel.values)))
        joined.append(Channel(name, time, values, channel.unit, channel.source, channel.note))
    derived = complete(Recording({channel.name: channel for channel in joined}), names).slice(begin)
    new = [channel for name, channel in derived.channels.items() if name not in recording]
    return recording.with_channels(new)


def read(
    path: str | Path,
    *,
    dbc: Paths = None,
    channel_map: str | Path | ChannelMap | None = None,
    names: Iterable[str] | None = None,
) -> Recording:
    """The recording in a file, with canonical names and in SI units.

    Args:
        path: file of any format in `READERS`, such as MF4, Parquet, CSV, MATLAB, MCAP, candump -L, ASC or BLF, or a
            folder with parts of one drive; text and CAN logs may be packed with gzip
        dbc: database of a CAN log, or several; a bare name such as "rav4" stands for a shipped one
        channel_map: TOML file that assigns columns to signals; a bare name stands for a shipped one;
            where not given, "car.channels.toml" beside "car.dbc" is used if it is there (metadata "channel_map")
        names: the signals (or columns) wanted, all where not given; signals that the file lacks are derived where
            tierod.io.derive has a recipe, and are absent otherwise

    Returns:
        time counts from the first stamp where the file has calendar time (metadata "origin" keeps it);
        guesses, repairs and losses are stated in `warnings` and in the notes of the channels

    Raises:
        InputError: the file, the database or the map cannot be used; the message states the remedy
        MissingExtra: the library for this format is not installed
    """
    names = None if names is None else tuple(names)
    used = loaded_map(channel_map)
    source, kind = open_source(path, dbc, used.time if used else None)
    (whole,) = Reading(path, source, kind, planned(path, source, used, names)).slices(math.inf)
    metadata = {key: value for key, value in whole.metadata.items() if key != SHARE_READ}
    whole = dataclasses.replace(whole, metadata=metadata)
    return whole if names is None else complete(whole, names)
