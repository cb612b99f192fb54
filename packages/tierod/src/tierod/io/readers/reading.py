"""Reading of a recording slice by slice or as a whole, in the same way for every format."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.series import CALENDAR, finite_or_missing
from tierod.core.signals import SIGNALS
from tierod.io.derive import RECIPES, complete, ingredients
from tierod.io.readers.channel_map import ChannelMap, load_channel_map, load_maps_beside
from tierod.io.readers.content import Allowance
from tierod.io.readers.mapping import Pick, Plan, plan
from tierod.io.readers.opening import Kind, Paths, open_source, shipped
from tierod.io.readers.slices import shifted, slices
from tierod.io.readers.source import Source

# Speed [m/s] that hardly any road vehicle reaches (216 km/h), but the numbers of any motorway drive in km/h do
FASTEST = 60.0


def made_from(plan: Plan, loaded: Sequence[Channel], doubts: Doubts) -> list[Channel]:
    by_name = {channel.name: channel for channel in loaded}
    channels = []
    for pick in plan.picks:
        parts = [by_name[column] for column in pick.columns if column in by_name]
        if len(parts) < len(pick.columns) or (pick.sign_from and pick.sign_from not in by_name):
            continue
        if pick.sign_from:
            parts = [with_sign(part, by_name[pick.sign_from]) for part in parts]
        channel = doubts.measured(_made(pick, parts))
        channels.append(channel)
        if pick.assumed:
            doubts.see(channel)
    return channels


# Multiple of the plausible range of a signal from which a number is no measurement, whatever the fault of its sensor
# and its unit: a code for a missing value, such as 3.4e38, or damage. Its powers would exceed the range of a float.
BEYOND: Annotated[float, ""] = 1e6


class Doubts:
    """What is doubtful in the values so far: magnitudes of signals without a unit, numbers that are no measurement."""

    def __init__(self) -> None:
        self._most: dict[str, float] = {}
        self._beyond: dict[str, int] = {}

    def measured(self, channel: Channel) -> Channel:
        """The next stretch of a channel, with numbers beyond any physical range missing, counted in its note."""
        known = SIGNALS.get(channel.name)
        if known is not None and channel.unit == known.unit:
            far = np.abs(channel.values) > BEYOND * max(map(abs, known.plausible))
            if count := int(np.count_nonzero(far)):
                self._beyond[channel.name] = self._beyond.get(channel.name, 0) + count
                channel = replace(channel, values=np.where(far, np.nan, channel.values))
        count = self._beyond.get(channel.name, 0)
        return channel.noted(f"{count} values beyond any physical range taken as missing" if count else "")

    def see(self, channel: Channel) -> None:
        finite = channel.values[np.isfinite(channel.values)]
        if len(finite):
            self._most[channel.name] = max(self._most.get(channel.name, 0.0), float(np.abs(finite).max()))

    def sentences(self, plan: Plan) -> tuple[str, ...]:
        seen = (pick for pick in plan.picks if pick.assumed and pick.name in self._most)
        return tuple(filter(None, (_doubt(pick, self._most[pick.name]) for pick in seen)))


def _made(pick: Pick, parts: list[Channel]) -> Channel:
    values = parts[0].values
    for part in parts[1:]:
        if len(part.time) != len(parts[0].time) or not np.array_equal(part.time, parts[0].time):
            raise InputError(
                f"'{pick.name}': the sources {', '.join(pick.columns)} have different time stamps and cannot be summed"
            )
        with np.errstate(over="ignore"):
            values = values + part.values
    values = np.asarray(values, dtype=float)
    gain = pick.entry.sign * pick.entry.factor
    with np.errstate(over="ignore"):  # what exceeds the range of a float is missing, and noted
        if gain != 1.0:
            values = gain * values
        if pick.entry.offset:
            values = values + pick.entry.offset
        values, infinite = finite_or_missing(pick.scale(values))
    source = " + ".join(part.source or part.name for part in parts)
    channel = Channel(pick.name, parts[0].time, values, pick.unit, source, parts[0].note)
    return channel.noted(*pick.notes, "values that are too large taken as missing" if infinite else "")


def with_sign(magnitude: Channel, bit: Channel) -> Channel:
    """The channel with minus where the latest sample of a bit is not 0; missing before its first."""
    if (bit.values < 0.0).any():  # in another piece of the column, 1 would be taken for a minus
        raise InputError(
            f"the column '{bit.name}' of the sign of '{magnitude.name}' holds {np.nanmin(bit.values):g}; "
            "sign_from takes a column that is 0 for plus and 1 for minus"
        )
    at = np.searchsorted(bit.time, magnitude.time, side="right") - 1
    held = np.where(at >= 0, bit.values[np.maximum(at, 0)], np.nan) if len(bit.time) else np.full(len(at), np.nan)
    values = np.where(np.isfinite(held), np.where(held != 0.0, -magnitude.values, magnitude.values), np.nan)
    return replace(magnitude, values=values)


def _doubt(pick: Pick, most: float) -> str:
    """Remark on a signal without a unit whose values, up to a magnitude, do not look like its SI unit."""
    known = SIGNALS[pick.name]
    low, high = known.plausible
    angular, speed = known.unit.startswith("rad"), known.unit == "m/s"
    place = f"{pick.name} ('{pick.columns[0]}') has no unit in the file and was taken as {known.unit}"
    if speed and most > FASTEST:
        return f'{place}, but reaches {most:.4g} m/s: if it is km/h, give unit = "km/h" in a channel map'
    if most > max(abs(low), abs(high)):
        guess = known.unit.replace("rad", "deg")
        in_degrees = angular and math.radians(most) <= max(abs(low), abs(high))
        looks = f'looks like {guess}: give unit = "{guess}"' if in_degrees else "is not plausible: give its unit"
        return f"{place}, but reaches {most:.4g} and {looks} in a channel map"
    return f"{place}: confirm it in a channel map" if angular or speed else ""


def measured(recording: Recording) -> Recording:
    """A recording made by a program, with numbers beyond any physical range missing, as in one that is read."""
    doubts = Doubts()
    return replace(recording, channels={name: doubts.measured(each) for name, each in recording.channels.items()})


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
    """Plan of the columns of an opened file that become channels."""
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
        """The channels of the plan, slice by slice, without derived signals."""
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
    """A slice with its derived signals, which also use the end of the slice before it."""
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
