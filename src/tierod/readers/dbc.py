"""Databases of CAN messages (DBC), and which of their messages a log holds."""

from __future__ import annotations

import contextlib
import logging
import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tierod.errors import InputError, MissingExtra
from tierod.readers.bits import Payloads, span
from tierod.readers.frames import EXTENDED, Frames, identifier_text, messages
from tierod.readers.j1939 import parameter_group, without_value
from tierod.readers.source import Column, Source
from tierod.recording import Channel
from tierod.user_files import MOST_DATA_BYTES, read_bytes

_KINDS = ("arxml", "dbc", "kcd", "sym", "cdd")
_ENTRY = re.compile(r"""\b(VAL_|SIG_VALTYPE_)\s+(\d+)\s+(\w+)\b(?:"(?:[^"\\]|\\.)*"|[^;"])*;""")


@dataclass(frozen=True)
class Found:
    """A message of the database that a log holds.

    Args:
        message: as cantools describes it
        prefix: of the names of its signals
        rows: of the frames
        where: identifier and bus, for the source of a channel
    """

    message: Any
    prefix: str
    rows: np.ndarray
    where: str


def load_databases(paths: Sequence[str | Path]) -> list[Any]:
    """The messages of one or several databases.

    Raises:
        MissingExtra: cantools is not installed
        InputError: a file that cannot be read or is no database
    """
    try:
        import cantools
    except ImportError:
        raise MissingExtra("cantools", "can", "decoding a CAN log") from None
    found: list[Any] = []
    for path in paths:
        content = read_bytes(path, "the CAN database", most=MOST_DATA_BYTES)
        try:
            with _quiet():
                found += getattr(_database(cantools, Path(path), content), "messages", [])
        except Exception as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"{path} is not a CAN database that can be read: {reason}; give a DBC file") from None
    if not found:
        raise InputError(f"{', '.join(map(str, paths))} describes no CAN message; give the DBC of this vehicle")
    return found


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without what cantools warns and logs of names that come twice: identifiers decide here."""
    logger = logging.getLogger("cantools")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)


def _database(cantools: Any, path: Path, content: bytes) -> Any:
    """A database; entries on signals that it does not describe, which cantools refuses, are left out of a DBC.

    Its letters are those that cantools expects: Windows-1252 in a DBC and SYM file, UTF-8 in all others.
    """
    kind = path.suffix[1:].lower()
    text = content.decode("cp1252" if kind in ("dbc", "sym") else "utf-8", errors="replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    try:
        return cantools.database.load_string(text, kind if kind in _KINDS else None, strict=False)
    except cantools.database.UnsupportedDatabaseFormatError as error:
        orphans = re.findall(r"(VAL_|SIG_VALTYPE_) (\d+) (\w+)", str(error))
        if "unused" not in str(error) or not orphans:
            raise
    left_out = set(orphans)
    text = _ENTRY.sub(lambda entry: "" if entry.groups() in left_out else entry[0], text)
    return cantools.database.load_string(text, "dbc", strict=False)


def match_messages(frames: Frames, database: Sequence[Any]) -> list[Found]:
    """The messages of a database that a log holds, one per message, bus and sender.

    Raises:
        InputError: the log holds none of them; identifiers of both sides are named
    """
    exact = {message.frame_id | (EXTENDED if message.is_extended_frame else 0): message for message in database}
    groups = {parameter_group(message.frame_id): message for message in database if message.protocol == "j1939"}
    found, seen = [], set()
    ids: dict[int, int] = {}
    for identifier, bus, rows in messages(frames):
        ids[identifier] = ids.get(identifier, 0) + len(rows)
        message = exact.get(identifier)
        if message is None and identifier & EXTENDED:
            message = groups.get(parameter_group(identifier & ~EXTENDED))
        if message is None or message.is_container:
            continue
        where = f"{identifier_text(identifier)} on {frames.buses[bus]}"
        prefix = message.name
        if message.name in seen:
            prefix = f"{frames.buses[bus]}:{identifier_text(identifier)}:{message.name}"
        seen.add(message.name)
        found.append(Found(message, prefix, rows, where))
    if not found:
        raise InputError(_no_match(ids, exact))
    return found


def _no_match(log: dict[int, int], database: dict[int, Any]) -> str:
    def some(ids: list[int]) -> str:
        text = ", ".join(identifier_text(identifier) for identifier in ids[:6])
        return text + (f" and {len(ids) - 6} more" if len(ids) > 6 else "")

    frequent = sorted(log, key=lambda identifier: -log[identifier])
    return (
        f"the DBC matches no frame of the log: the log holds {some(frequent)}, the DBC {some(sorted(database))}; "
        "give the DBC of this vehicle and bus"
    )


def bus_source(frames: Frames, database: Sequence[Any], metadata: dict[str, Any]) -> Source:
    """A CAN log with its database as a source of columns named "Message.Signal".

    A message that several buses or senders carry keeps its plain name for the first and gets a prefix for the others.
    """
    found = match_messages(frames, database)
    places = {f"{entry.prefix}.{item.name}": (entry, item) for entry in found for item in entry.message.signals}
    columns = tuple(Column(name, item.unit or "", item.name, True) for name, (_, item) in places.items())

    def load(names: Sequence[str]) -> list[Channel]:
        rows: dict[str, Rows] = {}
        channels = []
        for name in names:
            entry, item = places[name]
            if entry.prefix not in rows:
                rows[entry.prefix] = Rows.of(frames, entry)
            channels.append(_channel(name, entry, item, rows[entry.prefix]))
        return channels

    metadata = {**metadata, "frames": len(frames), "messages": len(found), "buses": frames.buses}
    came = {entry.message.name for entry in found}
    silent = tuple(f"{each.name}.{item.name}" for each in database if each.name not in came for item in each.signals)
    return Source(columns, load, metadata, frames.origin, frames.notes, silent=silent)


@dataclass(frozen=True)
class Rows:
    """The frames of one message.

    Args:
        time: [s], shape (n,)
        payloads: their bytes
        length: bytes of each payload, shape (n,)
        shortest: the least of them
    """

    time: np.ndarray
    payloads: Payloads
    length: np.ndarray
    shortest: int

    @staticmethod
    def of(frames: Frames, entry: Found) -> Rows:
        """The rows of a message that was found in a log."""
        length = frames.length[entry.rows]
        return Rows(frames.time[entry.rows], Payloads(frames.payload[entry.rows]), length, int(length.min()))


def _channel(name: str, entry: Found, item: Any, rows: Rows) -> Channel:
    time, values = rows.time, physical(entry.message, item, rows)
    chosen = selected(entry.message, item, rows)
    if chosen is not None:
        time, values = time[chosen], values[chosen]
    return Channel(name, time, values, item.unit or "", f"{name} ({entry.where})")


def selected(message: Any, item: Any, rows: Rows) -> np.ndarray | None:
    """Which frames carry a multiplexed signal; None where all do. Multiplexers may be multiplexed themselves."""
    if not item.multiplexer_ids or not item.multiplexer_signal:
        return None
    selector = message.get_signal_by_name(item.multiplexer_signal)
    mask = np.isin(_raw(selector, rows), np.array(item.multiplexer_ids, dtype=np.uint64))
    mask &= rows.length >= _bytes(selector)
    above = selected(message, selector, rows)
    return mask if above is None else mask & above


def physical(message: Any, item: Any, rows: Rows) -> np.ndarray:
    """The values of a signal; NaN where the frame is too short for it, or a J1939 sender has none to give."""
    raw = _raw(item, rows)
    with np.errstate(all="ignore"):
        values = raw.astype(float)
        if item.scale != 1:
            values *= float(item.scale)
        if item.offset != 0:
            values += float(item.offset)
    if rows.shortest < _bytes(item):
        values[rows.length < _bytes(item)] = np.nan
    silent = without_value(item, raw) if message.protocol == "j1939" else None
    if silent is not None:
        values[silent] = np.nan
    return values


def _raw(item: Any, rows: Rows) -> np.ndarray:
    big_endian = item.byte_order == "big_endian"
    return rows.payloads.raw(item.start, item.length, big_endian, bool(item.is_signed), bool(item.is_float))


def _bytes(item: Any) -> int:
    """How many bytes a frame needs to hold a signal."""
    return -(-span(item.start, item.length, item.byte_order == "big_endian")[1] // 8)
