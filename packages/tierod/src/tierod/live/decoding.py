"""CAN databases and channel map of a vehicle's buses, and the decoding of frames into signals while they arrive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.recording import Channel
from tierod.io.readers.channel_map import ChannelMap, load_maps_beside, maps_beside
from tierod.io.readers.dbc import Described, Rows, channel_of, described, load_databases, silent_channels
from tierod.io.readers.frames import EXTENDED, Frames, Heard, identifier_text, messages
from tierod.io.readers.opening import Paths, shipped
from tierod.io.readers.reading import loaded_map
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import Map, read_by

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal

NAMED = 3  # Number of messages that a sentence names; further ones are counted only


class BusFiles(NamedTuple):
    """CAN databases and channel map by which frames are decoded.

    `map_named` is the map as given or as the vehicle file names it; None where maps beside the databases are used.
    """

    paths: list[Path]
    database: list[Message]
    channel_map: ChannelMap | None
    map_named: Map


def bus_files(car: Vehicle, dbc: Paths = None, channel_map: Map = None) -> BusFiles:
    """The files that are given, else those of the vehicle; without a map, the maps beside the databases.

    Args:
        dbc: path(s) of databases

    Raises:
        ParameterError: no database is given, and the vehicle names none
        InputError: a file cannot be read
    """
    databases, named = read_by(car, dbc, channel_map)
    if not databases:
        raise ParameterError(f"the vehicle '{car.name}' names no CAN database; give one with --dbc")
    paths = [shipped(each, ".dbc") for each in databases]
    beside = () if named else maps_beside(paths)
    return BusFiles(
        paths, load_databases(paths), load_maps_beside(beside) if beside else loaded_map(named), named or None
    )


def disagreements(databases: Mapping[Path, Sequence[Message]]) -> str:
    """Sentence on the messages that two databases describe differently, and which description is used; "" if all agree.

    Args:
        databases: messages by file, in the order in which they were given
    """
    known: dict[int, tuple[Path, Message]] = {}
    found: list[str] = []
    for path, described_ in databases.items():
        for message in described_:
            key = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
            if key in known and known[key][0] != path and (what := _difference(known[key][1], message)):
                found.append(f"{identifier_text(key)} ({what}; {path.name} is used, not {known[key][0].name})")
            known[key] = (path, message)
    if not found:
        return ""
    others = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return (
        f"the databases disagree on {', '.join(found[:NAMED])}{others}; give the DBC that is right for this bus last, "
        "or leave the other one out"
    )


def _difference(first: Message, second: Message) -> str:
    """The first signal whose description differs, in words; "" if none does."""
    before, after = ({each.name: each for each in message.signals} for message in (first, second))
    for name in dict.fromkeys((*before, *after)):
        if name not in before or name not in after:
            return f"only one has {name}"
        if _layout(before[name]) != _layout(after[name]):
            return f"{name} differs in bits, sign, factor, offset or unit"
    return ""


def _layout(item: Signal) -> tuple[object, ...]:
    """Position of a signal in its message and conversion of its bits into a value; equal for equal descriptions."""
    return (
        item.start, item.length, item.byte_order, item.is_signed, item.is_float, float(item.scale), float(item.offset),
        item.unit or "", tuple(item.multiplexer_ids or ()),
    )  # fmt: skip


class Decoder:
    """Registers the identifiers seen on each bus, and decodes those that the databases describe.

    `known` describes the frames seen so far; None until one is in the databases. `version` counts its changes.
    """

    def __init__(self, database: Sequence[Message]):
        self._database = database
        self._counts: dict[tuple[int, int], int] = {}
        self._buses: dict[str, int] = {}
        self.known: Described | None = None
        self.version = 0

    def hear(self, frames: Frames) -> None:
        """Count the frames, and look up identifiers that are new."""
        new = False
        for identifier, bus, rows in messages(frames):
            key = (self._bus(frames, bus), identifier)
            new |= key not in self._counts
            self._counts[key] = self._counts.get(key, 0) + len(rows)
        if new:
            self._look_up()

    def _bus(self, frames: Frames, number: int) -> int:
        return self._buses.setdefault(frames.buses[number], len(self._buses))

    def _look_up(self) -> None:
        from tierod.core.errors import InputError

        heard = Heard(dict(sorted(self._counts.items())), tuple(self._buses), sum(self._counts.values()))
        try:
            found = described(heard, self._database)
        except InputError:
            return
        if self.known is None or found.found.keys() != self.known.found.keys():
            self.known = found
            self.version += 1

    @property
    def buses(self) -> dict[int, str]:
        """Names of the buses by their number in `known`."""
        return {number: name for name, number in self._buses.items()}

    def channels(self, frames: Frames, names: Sequence[str]) -> list[Channel]:
        """Channels of the named columns in some frames; without samples where no frame carries the column."""
        assert self.known is not None
        wanted = self.known.wanted(names)
        found = {}
        for identifier, bus, index in messages(frames):
            key = (self._bus(frames, bus), identifier)
            if key in wanted:
                rows = Rows.of(frames, index)
                entry = self.known.found[key]
                found[key] = [channel_of(name, entry, item, rows) for name, item in wanted[key]]
        channels = []
        for key, items in wanted.items():
            channels += found.get(key) or silent_channels(self.known.found[key], items)
        return channels
