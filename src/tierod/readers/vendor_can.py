"""CAN logs of vendors (ASC, BLF, TRC) through python-can."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from tierod.errors import InputError, MissingExtra
from tierod.readers.frames import EXTENDED, Frames

_BLF_FILE_SIZE = 16
"""Offset of the size of the whole file [bytes] in the header of a BLF file."""


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
    rows: list[Any] = []
    damage = ""
    try:
        with _quiet():
            for message in _reader(can, data, kind):
                if not (message.is_error_frame or message.is_remote_frame):
                    rows.append(message)
    except Exception as error:
        damage = " ".join(str(error).split())[:120] or type(error).__name__
    if not rows:
        why = f"is damaged ({damage})" if damage else "holds no frame with data"
        raise InputError(f"the {kind.upper()} log {why}; record or export it again")
    if damage:
        return _frames(rows, (f"the log is damaged after {len(rows)} frames ({damage}); what follows was left out",))
    return _frames(rows, _cut_off(data) if kind == "blf" else ())


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
    text = io.StringIO(data.decode("latin-1"))
    if kind == "asc":
        return can.ASCReader(text, relative_timestamp=False)
    return can.TRCReader(text)


def _frames(rows: list[Any], notes: tuple[str, ...]) -> Frames:
    stamps = np.array([message.timestamp for message in rows], dtype=float)
    length = np.array([len(message.data) for message in rows])
    width = max(int(length.max()), 8)
    payload = np.frombuffer(b"".join(bytes(message.data).ljust(width, b"\0") for message in rows), dtype=np.uint8)
    buses: dict[str, int] = {}
    bus = [buses.setdefault(str(message.channel), len(buses)) for message in rows]
    identifier = [message.arbitration_id | (EXTENDED if message.is_extended_id else 0) for message in rows]
    return Frames(
        stamps - stamps[0],
        np.array(identifier, dtype=np.uint32),
        np.array(bus, dtype=np.uint16),
        payload.reshape(-1, width),
        length,
        tuple(buses),
        float(stamps[0]),
        notes,
    )
