"""CAN logs of vendors (ASC, BLF, TRC) through python-can."""

from __future__ import annotations

import contextlib
import io
import logging
import math
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from tierod.errors import InputError, MissingExtra
from tierod.readers.frames import EXTENDED, IDENTIFIERS, Frames, bus_number

_BLF_FILE_SIZE = 16
"""Offset of the size of the whole file [bytes] in the header of a BLF file."""

BLOCK = 100_000
"""Frames that are Python objects at a time: each takes 0.5 to 1 kB until it stands in arrays of 30 bytes."""


class Part(NamedTuple):
    """The frames of one block, their time as recorded."""

    time: np.ndarray
    identifier: np.ndarray
    bus: np.ndarray
    payload: np.ndarray
    length: np.ndarray


def read_frames(data: bytes, kind: str) -> Frames:
    """The frames of a log; what was lost because the log is damaged stands in its notes.

    Args:
        data: the whole file
        kind: "asc", "blf" or "trc"

    Raises:
        MissingExtra: python-can is not installed
        InputError: the log holds no frame, or is damaged from the start
    """
    try:
        import can
    except ImportError:
        raise MissingExtra("python-can", "can", f"reading a log in {kind.upper()} format") from None
    parts: list[Part] = []
    buses: dict[str, int] = {}
    damages: list[str] = []
    strange: Counter[str] = Counter()
    messages = _messages(can, data, kind, damages, strange)
    while rows := list(islice(messages, BLOCK)):
        parts.append(_part(rows, buses))
    damage = "".join(damages)
    if not parts:
        damage = damage or "; ".join(f"frames {what}" for what in strange)
        why = f"is damaged ({damage})" if damage else "holds no frame with data"
        raise InputError(f"the {kind.upper()} log {why}; record or export it again")
    notes = tuple(f"frames {what} were left out: {count}" for what, count in strange.items())
    if damage:
        count = sum(len(part.time) for part in parts)
        notes = (*notes, f"the log is damaged after {count} frames ({damage}); the rest was left out")
    elif kind == "blf":
        notes = (*notes, *_cut_off(data))
    return _together(parts, buses, notes)


def _messages(can: Any, data: bytes, kind: str, damages: list[str], strange: Counter[str]) -> Iterator[Any]:
    """The frames with data up to the end or to the damage, which is put into `damages`; impossible ones are counted."""
    try:
        with _quiet():
            for message in _reader(can, data, kind):
                if message.is_error_frame or message.is_remote_frame:
                    continue
                if not 0 <= message.arbitration_id < IDENTIFIERS:
                    strange["with an identifier of more than 29 bits"] += 1
                elif not math.isfinite(message.timestamp):
                    strange["without a time"] += 1
                else:
                    yield message
    except Exception as error:
        damages.append(" ".join(str(error).split())[:120] or type(error).__name__)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without what python-can logs of lines that it leaves out."""
    logger = logging.getLogger("can")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


def _cut_off(data: bytes) -> tuple[str, ...]:
    """A note where a BLF file is shorter than its header says: its reader ends there without a word."""
    size = int.from_bytes(data[_BLF_FILE_SIZE : _BLF_FILE_SIZE + 8], "little")
    if len(data) >= size:
        return ()
    return (f"the log is cut off: {len(data)} of {size} bytes are there; copy it again for the rest",)


def _reader(can: Any, data: bytes, kind: str) -> Iterable[Any]:
    if kind == "blf":
        return can.BLFReader(io.BytesIO(data))
    text = io.TextIOWrapper(io.BytesIO(data), encoding="latin-1", newline="\n")
    if kind == "asc":
        return can.ASCReader(text, relative_timestamp=False)
    return can.TRCReader(text)


def _part(rows: list[Any], buses: dict[str, int]) -> Part:
    length = np.array([len(message.data) for message in rows])
    width = max(int(length.max()), 8)
    payload = np.frombuffer(b"".join(bytes(message.data).ljust(width, b"\0") for message in rows), dtype=np.uint8)
    bus = [bus_number(buses, str(message.channel)) for message in rows]
    identifier = [message.arbitration_id | (EXTENDED if message.is_extended_id else 0) for message in rows]
    return Part(
        np.array([message.timestamp for message in rows], dtype=float),
        np.array(identifier, dtype=np.uint32),
        np.array(bus, dtype=np.uint16),
        payload.reshape(-1, width),
        length,
    )


def _together(parts: list[Part], buses: dict[str, int], notes: tuple[str, ...]) -> Frames:
    """The frames of all blocks, their time counted from the first."""
    width = max(part.payload.shape[1] for part in parts)
    wide = [part._replace(payload=np.pad(part.payload, ((0, 0), (0, width - part.payload.shape[1])))) for part in parts]
    whole = Part(*(np.concatenate(column) for column in zip(*wide, strict=True)))
    origin = float(whole.time[0])
    time = whole.time - origin
    return Frames(time, whole.identifier, whole.bus, whole.payload, whole.length, tuple(buses), origin, notes)
