"""Databases of CAN messages (DBC), and the decoding of the messages that a log holds."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.errors import InputError, MissingExtra
from tierod.core.recording import Channel
from tierod.core.user_files import MOST_DATA_BYTES, read_bytes
from tierod.io.libraries import muted
from tierod.io.readers.bits import Payloads, span
from tierod.io.readers.frames import EXTENDED, Frames, identifier_text, messages, parameter_group, without_value
from tierod.io.readers.log import Heard, InOrder, Log
from tierod.io.readers.source import Column, Lane, Piece, Source

if TYPE_CHECKING:
    from cantools.database.can import Message, Signal
    from cantools.database.can.database import Database as CanDatabase
    from cantools.database.diagnostics.database import Database as DiagnosticsDatabase

_KINDS = ("arxml", "dbc", "kcd", "sym", "cdd")
_ENTRY = re.compile(r"""\b(VAL_|SIG_VALTYPE_)\s+(\d+)\s+(\w+)\b(?:"(?:[^"\\]|\\.)*"|[^;"])*;""")


@dataclass(frozen=True)
class Found:
    """A message of the database that a log holds."""

    message: Message  # description of the message by cantools
    prefix: str  # prefix of the names of its signals
    where: str  # identifier and bus, for the source of a channel


def load_databases(paths: Sequence[str | Path]) -> list[Message]:
    """The messages of one or several databases."""
    try:
        import cantools  # noqa: F401
    except ImportError:
        raise MissingExtra("cantools", "can", "decoding a CAN log") from None
    found: list[Message] = []
    for path in paths:
        content = read_bytes(path, "the CAN database", most=MOST_DATA_BYTES)
        try:
            # cantools warns of duplicate names, but here identifiers decide.
            with muted("cantools", logging.ERROR), warnings.catch_warnings(action="ignore"):
                found += getattr(_database(Path(path), content), "messages", [])
        except Exception as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"{path} is not a CAN database that can be read: {reason}; give a DBC file") from None
    if not found:
        raise InputError(f"{', '.join(map(str, paths))} describes no CAN message; give the DBC of this vehicle")
    return found


def _database(path: Path, content: bytes) -> CanDatabase | DiagnosticsDatabase:
    """A database; entries of a DBC on signals that it does not describe, which cantools refuses, are left out.

    DBC and SYM files are in Windows-1252, unless their signs beyond ASCII are valid UTF-8; all others are in UTF-8.
    """
    import cantools.database

    kind = path.suffix[1:].lower()
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252" if kind in ("dbc", "sym") else "utf-8", errors="replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    try:
        return cantools.database.load_string(text, kind if kind in _KINDS else None, strict=False)
    except cantools.database.UnsupportedDatabaseFormatError as error:  # type: ignore[attr-defined]  # not re-exported
        orphans = re.findall(r"(VAL_|SIG_VALTYPE_) (\d+) (\w+)", str(error))
        if "unused" not in str(error) or not orphans:
            raise
    left_out = set(orphans)
    text = _ENTRY.sub(lambda entry: "" if entry.groups() in left_out else entry[0], text)
    return cantools.database.load_string(text, "dbc", strict=False)


def match_messages(log: Heard, database: Sequence[Message]) -> dict[tuple[int, int], Found]:
    """The messages of a database that a log holds, one per message, bus and sender, by bus and identifier."""
    exact = {message.frame_id | (EXTENDED if message.is_extended_frame else 0): message for message in database}
    groups = {parameter_group(message.frame_id): message for message in database if message.protocol == "j1939"}
    found: dict[tuple[int, int], Found] = {}
    seen = set()
    ids: dict[int, int] = {}
    for (bus, identifier), count in log.counts.items():
        ids[identifier] = ids.get(identifier, 0) + count
        message = exact.get(identifier)
        # In J1939, priority and sender in an identifier may differ from those in the database.
        if message is None and identifier & EXTENDED:
            message = groups.get(parameter_group(identifier & ~EXTENDED))
        if message is None or message.is_container:
            continue
        where = f"{identifier_text(identifier)} on {log.buses[bus]}"
        prefix = message.name
        if message.name in seen:
            prefix = f"{log.buses[bus]}:{identifier_text(identifier)}:{message.name}"
        seen.add(message.name)
        found[bus, identifier] = Found(message, prefix, where)
    if not found:
        raise InputError(_no_match(ids, exact))
    return found


def _no_match(log: dict[int, int], database: Collection[int]) -> str:
    def some(ids: list[int]) -> str:
        text = ", ".join(identifier_text(identifier) for identifier in ids[:6])
        return text + (f" and {len(ids) - 6} more" if len(ids) > 6 else "")

    frequent = sorted(log, key=lambda identifier: -log[identifier])
    return (
        f"the DBC matches no frame of the log: the log holds {some(frequent)}, the DBC {some(sorted(database))}; "
        "give the DBC of this vehicle and bus"
    )


@dataclass(frozen=True)
class Described:
    """Description of the frames of a bus by databases."""

    found: dict[tuple[int, int], Found]  # messages in the log, by bus and identifier
    # (bus and identifier of its message, signal) of every signal in the log, by the name of its column
    places: dict[str, tuple[tuple[int, int], Signal]]
    columns: tuple[Column, ...]  # columns "Message.Signal"
    silent: tuple[str, ...]  # names of the columns of messages that are not in the log

    def wanted(self, names: Sequence[str]) -> dict[tuple[int, int], list[tuple[str, Signal]]]:
        """(name of the column, signal) of the named columns, by bus and identifier."""
        wanted: dict[tuple[int, int], list[tuple[str, Signal]]] = {}
        for name in names:
            key, item = self.places[name]
            wanted.setdefault(key, []).append((name, item))
        return wanted


def described(content: Heard, database: Sequence[Message]) -> Described:
    """Description of the received frames by databases.

    A message on several buses or from several senders keeps its plain name for the first, the others get a prefix.
    """
    found = match_messages(content, database)
    places = {
        f"{entry.prefix}.{item.name}": (key, item) for key, entry in found.items() for item in entry.message.signals
    }
    columns = tuple(Column(name, item.unit or "", item.name, True) for name, (_, item) in places.items())
    came = {entry.message.name for entry in found.values()}
    silent = tuple(f"{each.name}.{item.name}" for each in database if each.name not in came for item in each.signals)
    return Described(found, places, columns, silent)


def bus_source(log: Log, content: Heard, database: Sequence[Message], metadata: Mapping[str, object]) -> Source:
    """A CAN log with its database as a source of columns named "Message.Signal"."""
    known = described(content, database)

    def lanes(names: Sequence[str]) -> list[Lane]:
        return [_decoded(log, content, known.found, known.wanted(names))]

    metadata = {**metadata, "frames": content.frames, "messages": len(known.found), "buses": content.buses}
    return Source(known.columns, lanes, metadata, content.origin, content.notes, silent=known.silent)


def _decoded(
    log: Log,
    content: Heard,
    found: dict[tuple[int, int], Found],
    wanted: dict[tuple[int, int], list[tuple[str, Signal]]],
) -> Lane:
    """The wanted signals of a log, block by block; the first piece has all without samples: a message may come late."""
    yield Piece([channel for key, items in wanted.items() for channel in silent_channels(found[key], items)])
    done = 0
    for frames in InOrder(log):
        channels = []
        for identifier, bus, index in messages(frames):
            if (bus, identifier) in wanted:
                rows = Rows.of(frames, index)
                entry = found[bus, identifier]
                channels += [channel_of(name, entry, item, rows) for name, item in wanted[bus, identifier]]
        done += len(frames)
        yield Piece(channels, done / content.frames)


@dataclass(frozen=True)
class Rows:
    """The frames of one message."""

    time: np.ndarray  # [s], shape (n,)
    payloads: Payloads  # bytes of the frames
    length: np.ndarray  # number of bytes of each payload, shape (n,)
    shortest: int  # smallest of these numbers

    @staticmethod
    def of(frames: Frames, index: np.ndarray) -> Rows:
        """Those rows of the frames that an index selects."""
        length = frames.length[index]
        return Rows(frames.time[index], Payloads(frames.payload[index]), length, int(length.min()))


def silent_channels(entry: Found, items: Sequence[tuple[str, Signal]]) -> list[Channel]:
    """Signals of a message, without samples; those that every frame carries share their time stamps."""
    none = np.empty((0, 8), dtype=np.uint8)
    rows = Rows(np.empty(0), Payloads(none), np.empty(0, dtype=int), 8)
    return [channel_of(name, entry, item, rows) for name, item in items]


def channel_of(name: str, entry: Found, item: Signal, rows: Rows) -> Channel:
    """A signal of some frames of its message, in the unit of the database."""
    time, values = rows.time, physical(entry.message, item, rows)
    chosen = selected(entry.message, item, rows)
    if chosen is not None:
        time, values = time[chosen], values[chosen]
    return Channel(name, time, values, item.unit or "", f"{name} ({entry.where})")


def selected(message: Message, item: Signal, rows: Rows) -> np.ndarray | None:
    """Mask of frames that carry a multiplexed signal; None where all do. Multiplexers may be multiplexed themselves."""
    if not item.multiplexer_ids or not item.multiplexer_signal:
        return None
    selector = message.get_signal_by_name(item.multiplexer_signal)
    mask = np.isin(_raw(selector, rows), np.array(item.multiplexer_ids, dtype=np.uint64))
    mask &= rows.length >= bytes_of(selector)
    above = selected(message, selector, rows)
    return mask if above is None else mask & above


def physical(message: Message, item: Signal, rows: Rows) -> np.ndarray:
    """The values of a signal; NaN where the frame is too short for it, or a J1939 sender marks it as without value."""
    raw = _raw(item, rows)
    with np.errstate(all="ignore"):
        values = raw.astype(float)
        if item.scale != 1:
            values *= float(item.scale)
        if item.offset != 0:
            values += float(item.offset)
    if rows.shortest < bytes_of(item):
        values[rows.length < bytes_of(item)] = np.nan
    silent = without_value(item, raw) if message.protocol == "j1939" else None
    if silent is not None:
        values[silent] = np.nan
    return values


def _raw(item: Signal, rows: Rows) -> np.ndarray:
    big_endian = item.byte_order == "big_endian"
    return rows.payloads.raw(item.start, item.length, big_endian, bool(item.is_signed), bool(item.is_float))


def bytes_of(item: Signal) -> int:
    """Number of bytes that a frame needs to hold a signal."""
    return -(-span(item.start, item.length, item.byte_order == "big_endian")[1] // 8)
