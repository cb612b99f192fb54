"""CAN logs in vendor formats (BLF, TRC) through python-can; containers of BLF are unpacked within limits."""

from __future__ import annotations

import io
import logging
import math
import re
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.errors import InputError, MissingExtra, TierodError
from tierod.io.formats import muted
from tierod.io.readers.content import Allowance, Content, Stream, whole_lines
from tierod.io.readers.frames import EXTENDED, IDENTIFIERS, Frames, Log, Remembered, bus_number, only_notes, stacked
from tierod.io.readers.source import Format, begins_with, text_begin

if TYPE_CHECKING:
    import can

_SIZE_OF_FILE = 16  # Offset of the size of the whole file [bytes] in the header
_HEADER = struct.Struct("<4sHHII")  # Signature, size and version of the header, size of the object with header, type
_CONTAINER = struct.Struct("<HxxxxxxIxxxx")  # Compression method and unpacked size, before the content

_CONTAINER_TYPE, _PLAIN, _ZLIB = 10, 0, 2


def unpacked(content: Content) -> Iterator[bytes]:
    """The bytes of a BLF file with every packed container replaced by one that is not packed."""
    allowance = Allowance(content.path, content.size)
    objects = _Objects(allowance)
    with content.stream() as stream:
        begin = stream.read(8)
        size = int.from_bytes(begin[4:], "little")
        allowance.take_block(size)
        yield begin + stream.read(max(size - len(begin), 0))
        while header := stream.read(_HEADER.size):
            if len(header) < _HEADER.size:
                return
            sign, size_of_header, version, size, kind = _HEADER.unpack(header)
            if size < _HEADER.size:
                raise ValueError(f"an object has {size} bytes, fewer than its header")
            allowance.take_block(size)
            body = stream.read(max(size - _HEADER.size, 0))
            padding = stream.read(size % 4)  # BLF pads by size % 4 bytes, not up to a multiple of four
            if sign == b"LOBJ" and kind == _CONTAINER_TYPE and len(body) >= _CONTAINER.size:
                method, declared = _CONTAINER.unpack_from(body)
                if method == _ZLIB:
                    plain = _inflated(body[_CONTAINER.size :], declared, allowance)
                    body = _CONTAINER.pack(_PLAIN, len(plain)) + plain
                    size = _HEADER.size + len(body)
                    header = _HEADER.pack(sign, size_of_header, version, size, kind)
                    padding = bytes(size % 4)
                objects.add(body[_CONTAINER.size :])
            allowance.take(len(body))
            yield header + body + padding


class _Objects:
    """Checks the objects in consecutive containers; an object may begin in one container and end in the next.

    python-can finds the next object by the size of the one before, and never ends where that size is invalid.
    """

    def __init__(self, allowance: Allowance):
        self._allowance, self._rest = allowance, b""

    def add(self, plain: bytes) -> None:
        data, place = self._rest + plain, 0
        while (place := data.find(b"LOBJ", place)) >= 0 and place + _HEADER.size <= len(data):
            size = _HEADER.unpack_from(data, place)[3]
            if size < _HEADER.size:
                raise ValueError(f"an object has {size} bytes, fewer than its header")
            self._allowance.take_block(size)
            if place + size > len(data):
                break
            place += size
        self._rest = data[place:] if place >= 0 else b""


def _inflated(packed: bytes, declared: int, allowance: Allowance) -> bytes:
    """The content of a container, of a truncated one as far as it goes."""
    allowance.take_block(declared)
    worker, most = zlib.decompressobj(), allowance.limits.block
    try:
        plain = worker.decompress(packed, most)
    except zlib.error as error:
        raise ValueError(f"a container cannot be unpacked: {error}") from None
    if worker.unconsumed_tail:
        allowance.take_block(most + 1)
    return plain


def cut_off(content: Content) -> str:
    """A note where a BLF file is shorter than its header states, which python-can does not report; else ""."""
    head = content.head(_SIZE_OF_FILE + 8)
    size = int.from_bytes(head[_SIZE_OF_FILE:], "little")
    there = sum(map(len, content.blocks())) if content.packed else content.size
    return "" if there >= size else f"the log is cut off: {there} of {size} bytes are there; copy it again for the rest"


_TRC = re.compile(rb"^;(\$FILEVERSION|#{10})|^;.*PCAN", re.IGNORECASE)

BLOCK = 10_000  # Number of frames that are Python objects at a time: each takes 0.5 to 1 kB, but in arrays 30 bytes


def frames_of(content: Content, kind: str) -> Iterator[Frames]:
    """The frames of a log, block by block; the last block has the notes on losses by damage."""
    try:
        import can  # noqa: F401
    except ImportError:
        raise MissingExtra("python-can", "can", f"reading a log in {kind.upper()} format") from None
    buses: dict[str, int] = {}
    damages: list[str] = []
    strange: Counter[str] = Counter()
    messages = _messages(content, kind, damages, strange)
    count = 0
    frames: Frames | None = None
    while rows := list(islice(messages, BLOCK)):
        frames = _frames(rows, buses, frames.origin if frames else None)
        count += len(frames)
        yield frames
    damage = "".join(damages)
    if frames is None:
        damage = damage or "; ".join(f"frames {what}" for what in strange)
        why = f"is damaged ({damage})" if damage else "holds no frame with data"
        raise InputError(f"the {kind.upper()} log {why}; record or export it again")
    notes = [f"frames {what} were left out: {number}" for what, number in strange.items()]
    if damage:
        notes.append(f"the log is damaged after {count} frames ({damage}); the rest was left out")
    elif kind == "blf":
        notes.append(cut_off(content))
    yield only_notes(frames, tuple(filter(None, notes)))


def _messages(content: Content, kind: str, damages: list[str], strange: Counter[str]) -> Iterator[can.Message]:
    """The frames with data, up to the end or to damage, which is noted in `damages`; invalid ones are counted."""
    try:
        with muted("can", logging.CRITICAL + 1):  # python-can logs the lines that it leaves out
            for message in _reader(content, kind):
                if message.is_error_frame or message.is_remote_frame:
                    continue
                if not 0 <= message.arbitration_id < IDENTIFIERS:
                    strange["with an identifier of more than 29 bits"] += 1
                elif not math.isfinite(message.timestamp):
                    strange["without a time"] += 1
                else:
                    yield message
    except TierodError:
        raise
    except Exception as error:
        damages.append(" ".join(str(error).split())[:120] or type(error).__name__)


def _reader(content: Content, kind: str) -> Iterable[can.Message]:
    import can

    reader: Iterable[can.Message]
    if kind == "blf":
        reader = can.BLFReader(io.BufferedReader(Stream(unpacked(content))))
        return reader
    lines = whole_lines(content.blocks(), content.path)
    text = io.TextIOWrapper(io.BufferedReader(Stream(lines)), encoding="latin-1", newline="\n")
    reader = can.TRCReader(text)
    return reader


def _frames(rows: Sequence[can.Message], buses: dict[str, int], origin: float | None) -> Frames:
    time = np.array([message.timestamp for message in rows], dtype=float)
    bus = [bus_number(buses, str(message.channel)) for message in rows]
    identifier = [message.arbitration_id | (EXTENDED if message.is_extended_id else 0) for message in rows]
    origin = float(time[0]) if origin is None else origin
    return stacked(time - origin, identifier, bus, [bytes(each.data) for each in rows], tuple(buses), origin)


def _format(name: str, recognises: Callable[[bytes, str], bool], text: bool) -> Format:
    return Format(
        name,
        f"{name.upper()} (.{name})",
        (f".{name}",),
        lambda content, time: Log(content.path.name, Remembered(lambda: frames_of(content, name))),
        recognises,
        text,
    )


BLF = _format("blf", begins_with(b"LOGG"), text=False)
TRC = _format("trc", lambda head, ending: _TRC.match(text_begin(head)) is not None, text=True)
