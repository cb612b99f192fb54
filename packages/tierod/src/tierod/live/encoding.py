"""Encoding of a recording's signals into frames by a database: the reverse of decoding, in the database's units."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.core.units import scale, split_suffix, tidy
from tierod.io.readers.channel_map import ChannelMap, Entry
from tierod.io.readers.frames import EXTENDED
from tierod.io.readers.opening import open_source
from tierod.io.readers.reading import Reading
from tierod.io.readers.source import Column
from tierod.live.clock import Frame

if TYPE_CHECKING:
    from cantools.database.can import Message

Conversion = Callable[[np.ndarray], np.ndarray]  # Conversion of a column's values into the physical values of a signal

NAMED = 5  # Number of signals that a remark names; the others are counted


@dataclass
class Differences:
    """What the frames do not carry as the recording has it, by signal or message."""

    # number of values beyond the range of the signal's bits, which are sent as its limit
    limited: Counter[str] = field(default_factory=Counter)
    # number of frames that are not sent while this signal of them is missing
    missing: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)  # number of frames that the database cannot encode
    # signals that the recording lacks; they are sent with a constant value
    absent: list[str] = field(default_factory=list)

    def sentences(self) -> tuple[str, ...]:
        several = (
            (self.limited, "values beyond the range of {name} were sent as its limit"),
            (self.missing, "frames were not sent, since {name} is missing there"),
            (self.refused, "frames of {name} were not sent, since the database cannot encode them"),
        )
        said = [f"{number} {text.format(name=name)}" for counts, text in several for name, number in counts.items()]
        if self.absent:
            more = f" and {len(self.absent) - NAMED} more" if len(self.absent) > NAMED else ""
            said.append(f"constant on the bus, since the recording lacks them: {', '.join(self.absent[:NAMED])}{more}")
        return tuple(said)


class Wire(NamedTuple):
    """A column of the recording, and the conversion of its values into a signal."""

    column: str
    convert: Conversion


def encoded(
    path: Path,
    database: Sequence[Message],
    channel_map: ChannelMap | None,
    differences: Differences | None = None,
) -> Iterator[Frame]:
    """Frames of a recording's signals; a message is sent at each sample of its fastest signal, the others are held.

    Args:
        path: path of the recording, with columns of the databases or canonical signals
        channel_map: channel map of the vehicle, whose sign, factor and offset are inverted

    Raises:
        InputError: the recording holds no signal of the databases, or a column whose unit cannot become the signal's
    """
    from tierod.io.conversion import as_found

    differences = differences if differences is not None else Differences()
    source, kind = open_source(path)
    columns = {column.name: column for column in source.columns} | {column.title: column for column in source.columns}
    try:
        wired = {message.name: wires for message in database if (wires := _wires(message, columns, channel_map))}
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if not wired:
        raise InputError(
            f"{path} has no signal of the databases; give columns called Message.Signal, or a channel map with --map "
            "that assigns signals of the DBC to canonical names"
        )
    senders = [_Sender(message, wired[message.name], differences) for message in database if message.name in wired]
    first = None
    for piece in Reading(path, source, kind, as_found(source)).slices(10.0):
        for frame in heapq.merge(*(sender.frames(piece) for sender in senders)):
            first = frame.time if first is None else first
            yield frame._replace(time=frame.time - first)


def _wires(message: Message, columns: Mapping[str, Column], channel_map: ChannelMap | None) -> dict[str, Wire]:
    """By signal of a message, the column that it is sent from.

    Raises:
        InputError: the unit of a column is not known, or cannot become that of its signal
    """
    wires: dict[str, Wire] = {}
    for item in message.signals:
        name, unit = f"{message.name}.{item.name}", item.unit or ""
        mapped = {
            canonical: entry
            for canonical, entry in (channel_map.entries if channel_map else {}).items()
            if entry.source in ((name,), (item.name,))
        }
        column = columns.get(name) or columns.get(item.name)
        if column is not None:
            conversion = _of_signal(column, name, unit, mapped)
            wires[item.name] = Wire(column.name, _magnitude(conversion) if _has_bit(mapped) else conversion)
            continue
        for canonical, entry in mapped.items():
            if canonical in columns:
                wires[item.name] = Wire(columns[canonical].name, _of_canonical(columns[canonical], name, unit, entry))
                break
        for canonical, entry in (channel_map.entries if channel_map else {}).items():
            if entry.sign_from in (name, item.name) and canonical in columns:
                wires[item.name] = Wire(columns[canonical].name, lambda values: (values < 0.0).astype(float))
    return wires


def _of_signal(column: Column, name: str, unit: str, mapped: Mapping[str, Entry]) -> Conversion:
    own = _unit_of(column)
    if own.strip() == unit.strip() or (not own and mapped):
        # The map describes columns of this name, in a log as in this file: both have the unit of the database.
        return lambda values: values
    plain = next((pair for pair in mapped.items() if (pair[1].sign, pair[1].factor, pair[1].offset) == (1, 1, 0)), None)
    if not unit and plain is not None:
        unit = plain[1].unit or SIGNALS[plain[0]].unit
    return _conversion(column, own, name, unit)


def _of_canonical(column: Column, name: str, unit: str, entry: Entry) -> Conversion:
    canonical = column.title or column.name
    back = _conversion(column, _unit_of(column), name, entry.unit or unit or SIGNALS[canonical].unit)
    gain, offset = entry.sign * entry.factor, entry.offset
    conversion: Conversion = lambda values: (back(values) - offset) / gain  # noqa: E731
    return _magnitude(conversion) if entry.sign_from else conversion


def _has_bit(mapped: Mapping[str, Entry]) -> bool:
    return any(entry.sign_from for entry in mapped.values())


def _magnitude(conversion: Conversion) -> Conversion:
    return lambda values: np.abs(conversion(values))


def _unit_of(column: Column) -> str:
    return column.unit or split_suffix(column.name)[1]


def _conversion(column: Column, own: str, name: str, unit: str) -> Conversion:
    """Conversion between two units.

    Raises:
        InputError: one of the units is not given, not known, or of another kind
    """
    title = column.title or column.name
    if not own and tidy(unit):
        raise InputError(
            f"the column '{title}' has no unit, and {name} is sent in {unit}; write the unit into the title of the "
            f"column, as in '{title} [{unit}]', or name {name} as a source in a channel map (--map)"
        )
    try:
        if not unit and tidy(own):
            raise InputError(f"the database gives {name} no unit, and the column '{title}' is in {own}; add its unit")
        return scale(own, unit)
    except InputError as error:
        cure = "" if "; " in str(error) else f"; correct the unit of '{title}', or that of {name} in the database"
        raise InputError(f"'{title}' cannot be sent as {name}: {error}{cure}") from None


class _Sender:
    """Encodes one message piece by piece; the latest value of each signal is held into the next piece."""

    def __init__(self, message: Message, wires: Mapping[str, Wire], differences: Differences):
        self._message, self._wires, self._differences = message, wires, differences
        self._identifier = message.frame_id | (EXTENDED if message.is_extended_frame else 0)
        self._last = dict.fromkeys(wires, np.nan)
        self._rest = {item.name: _raw(item, _idle(item)) for item in message.signals if item.name not in wires}
        differences.absent += [f"{message.name}.{name}" for name in self._rest]

    def frames(self, piece: Recording) -> Iterator[Frame]:
        from cantools.database import EncodeError

        channels = {
            name: piece.channels[wire.column] for name, wire in self._wires.items() if wire.column in piece.channels
        }
        if not channels:
            return
        time = max(channels.values(), key=lambda channel: len(channel.time)).time
        columns = {name: self._held(name, channels.get(name), time) for name in self._wires}
        there, title = np.ones(len(time), dtype=bool), self._message.name
        for name, values in columns.items():
            there &= np.isfinite(values)
            if lost := int(np.count_nonzero(np.isnan(values))):
                self._differences.missing[f"{title}.{name}"] += lost
        raws = {name: self._raws(name, values[there]) for name, values in columns.items()}
        for place, stamp in enumerate(time[there].tolist()):
            try:
                given = self._rest | {name: column[place] for name, column in raws.items()}
                data = self._message.encode(given, scaling=False, strict=False)
            except (EncodeError, OverflowError, ValueError):
                self._differences.refused[title] += 1
                continue
            yield Frame(stamp, self._identifier, 1, data)

    def _held(self, name: str, channel: Channel | None, time: np.ndarray) -> np.ndarray:
        """Physical values of a signal at some instants [s], each from the latest sample; NaN before the first."""
        if channel is None or not len(channel.time):
            return np.full(len(time), self._last[name])
        with np.errstate(over="ignore"):  # a value that becomes infinite is beyond the range of any signal
            values = np.asarray(self._wires[name].convert(channel.values), dtype=float)
        known = np.concatenate(([self._last[name]], values))
        self._last[name] = float(known[-1])
        values = known[np.searchsorted(channel.time, time, side="right")]
        return np.where(np.isinf(values), np.sign(values) * np.finfo(float).max, values)

    def _raws(self, name: str, values: np.ndarray) -> list[Any]:
        item: Any = self._message.get_signal_by_name(name)
        if item.is_float:
            return [(value - item.offset) / item.scale for value in values.tolist()]
        low, high = _limits(item)
        with np.errstate(over="ignore"):
            raw = np.rint((values - float(item.offset)) / float(item.scale))
        beyond = int(np.count_nonzero((raw < low) | (raw > high)))
        if beyond:
            self._differences.limited[f"{self._message.name}.{name}"] += beyond
        return [min(max(int(value), low), high) for value in np.clip(raw, low, high).tolist()]


def _limits(item: Any) -> tuple[int, int]:
    if item.is_signed:
        return -(1 << item.length - 1), (1 << item.length - 1) - 1
    return 0, (1 << item.length) - 1


def _raw(item: Any, value: float) -> float:
    raw = (value - float(item.offset)) / float(item.scale)
    return raw if item.is_float else min(max(round(raw), _limits(item)[0]), _limits(item)[1])


def _idle(item: Any) -> float:
    return float(item.offset) if not item.minimum or item.minimum <= item.offset else float(item.minimum)
