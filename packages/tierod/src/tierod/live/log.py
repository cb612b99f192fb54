"""Log of CAN frames as MF4 that can be read at any moment: records are appended, and their count is written last.

Until it is finished the file is marked as unfinalized (`UnFinMF`): readers derive the length of its last block and the
count of its records from the length of the file. Source: ASAM MDF 4.1, "Unfinalized MDF", and the bus logging standard.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from pathlib import Path
from xml.sax.saxutils import escape

from tierod.core.errors import OutputError
from tierod.core.files import expanded, require_folder
from tierod.core.version import __version__
from tierod.io.readers.frames import EXTENDED
from tierod.live.clock import Frame

_IDENTIFICATION, _LINKS = 64, 24
_UNFINISHED = 0b101
"""Flags of an unfinalized file: the count of records and the length of the last block must be updated."""

_FIELDS = (
    ("CAN_DataFrame.BusChannel", 8, 0, 8), ("CAN_DataFrame.ID", 9, 0, 32), ("CAN_DataFrame.IDE", 13, 0, 8),
    ("CAN_DataFrame.EDL", 14, 0, 8), ("CAN_DataFrame.DLC", 15, 0, 8), ("CAN_DataFrame.DataLength", 16, 0, 8),
)  # fmt: skip
"""Name, byte offset, bit offset and number of bits of each field of a record after its time."""

_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
_CODES = {length: code for code, length in enumerate(_LENGTHS)}
_PAYLOAD = 17  # Byte offset of the payload in a record


class _Blocks:
    def __init__(self) -> None:
        self.data = bytearray(_IDENTIFICATION)

    def add(self, kind: str, links: Iterable[int], body: bytes = b"") -> int:
        links = tuple(links)
        at, length = len(self.data), _LINKS + 8 * len(links) + len(body)
        self.data += struct.pack(f"<4s4xQQ{len(links)}Q", f"##{kind}".encode(), length, len(links), *links) + body
        self.data += bytes(-len(self.data) % 8)
        return at

    def text(self, text: str, kind: str = "TX") -> int:
        return self.add(kind, (), text.encode() + b"\0")

    def channel(
        self, following: int, part: int, name: str, layout: tuple[int, int, int, int, int], unit: int = 0
    ) -> int:
        """Append a channel block and return its address; layout: type, synchronisation, data type, byte, bits."""
        kind, sync, data_type, byte, bits = layout
        body = struct.pack("<4B4I2BHddd3d", kind, sync, data_type, 0, byte, bits, 0, 0, 0, 0, 0, *([0.0] * 6))
        return self.add("CN", (following, part, self.text(name), 0, 0, 0, unit, 0), body)


def _head(origin: int, width: int, comment: str) -> tuple[bytes, int, int]:
    """(everything before the records, address of the record count, address of the data block)."""
    blocks = _Blocks()
    # The header must be the first block; its links are set once the addresses of the others are known.
    header = blocks.add("HD", (0,) * 6, struct.pack("<QhhBBBBdd", origin * 10**9, 0, 0, 0, 0, 0, 0, 0.0, 0.0))
    history = blocks.text(
        "<FHcomment><TX>live log</TX><tool_id>tierod</tool_id><tool_vendor>tierod</tool_vendor>"
        f"<tool_version>{__version__}</tool_version></FHcomment>",
        "MD",
    )
    file_history = blocks.add("FH", (0, history), struct.pack("<QhhB3x", origin * 10**9, 0, 0, 0))
    part = blocks.channel(0, 0, "CAN_DataFrame.DataBytes", (0, 0, 10, _PAYLOAD, 8 * width))
    for name, byte, _, bits in reversed(_FIELDS):
        part = blocks.channel(part, 0, name, (0, 0, 0, byte, bits))
    frame = blocks.channel(0, part, "CAN_DataFrame", (0, 0, 10, 8, 8 * (_PAYLOAD - 8 + width)))
    time = blocks.channel(frame, 0, "Timestamp", (2, 1, 4, 0, 64), blocks.text("s"))
    source = blocks.add("SI", (blocks.text("CAN"), blocks.text("CAN"), 0), struct.pack("<BBB5x", 2, 2, 0))
    numbers = struct.pack("<QQHHIII", 0, 0, 6, ord("."), 0, _PAYLOAD + width, 0)
    group = blocks.add("CG", (0, time, blocks.text("CAN"), source, 0, 0), numbers)
    note = blocks.text(comment, "MD")
    data = blocks.add("DG", (0, group, 0, 0), struct.pack("<B7x", 0))
    at = blocks.add("DT", ())
    struct.pack_into("<Q", blocks.data, data + _LINKS + 16, at)
    struct.pack_into("<6Q", blocks.data, header + _LINKS, data, file_history, 0, 0, 0, note)
    head = struct.pack("<8s8s8s4xH30xHH", b"UnFinMF ", b"4.10    ", b"tierod  ", 410, _UNFINISHED, 0)
    blocks.data[:_IDENTIFICATION] = head
    return bytes(blocks.data), group + _LINKS + 48 + 8, at


def is_unfinished(path: Path) -> bool:
    """Whether a file is a log whose program ended without finishing it."""
    try:
        with path.open("rb") as file:
            return file.read(7) == b"UnFinMF"
    except OSError:
        return False


def refused(path: Path, error: OSError) -> OutputError:
    """The error that reports why a log cannot be written."""
    reason = (error.strerror or str(error)).lower()
    return OutputError(f"the log {path} cannot be written: {reason}; make room or name another place")


class FrameLog:
    """Appends frames to a file; frames passed to `append` survive a kill of the process.

    Args:
        origin: calendar time of the stamp zero, whole seconds [s since 1970]
        width: bytes of a payload: 8, or 64 for CAN FD

    Raises:
        OutputError: the file cannot be written
    """

    def __init__(self, path: str | Path, origin: float, width: int = 8, comment: str = ""):
        require_folder(path)
        self.path, self.width, self.count, self.shortened = expanded(path), width, 0, 0
        text = f"<HDcomment><TX>{escape(comment)}</TX></HDcomment>"
        head, self._count_at, self._data_at = _head(int(origin), width, text)
        self._pack = struct.Struct(f"<dBIBBBB{width}s").pack
        try:
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
            self._write(head)
        except OSError as error:
            raise refused(self.path, error) from None

    def append(self, frames: Iterable[Frame]) -> None:
        """Write frames at the end of the file.

        Raises:
            OutputError: the disk is full or gone; what was written before stays readable
        """
        records = []
        for time, identifier, bus, data in frames:
            length = len(data)
            if length > self.width:
                self.shortened += 1
                length, data = self.width, data[: self.width]
            extended, code = identifier >> 31, _CODES.get(length, 8)
            records.append(self._pack(time, bus, identifier & ~EXTENDED, extended, length > 8, code, length, data))
        try:
            self._write(b"".join(records))
        except OSError as error:
            self._forget_part()
            raise refused(self.path, error) from None
        self.count += len(records)

    def _write(self, data: bytes) -> None:
        left = memoryview(data)
        while left:
            left = left[os.write(self._file, left) :]

    def _forget_part(self) -> None:
        """Remove a record that was written only in part, which would shift all further ones."""
        size = self._data_at + _LINKS + self.count * (_PAYLOAD + self.width)
        try:
            os.ftruncate(self._file, size)
        except OSError:
            return

    def finish(self) -> None:
        """Write the count of records and close: from now on the file is an ordinary MF4."""
        size = _LINKS + self.count * (_PAYLOAD + self.width)
        try:
            os.pwrite(self._file, struct.pack("<Q", self.count), self._count_at)
            os.pwrite(self._file, struct.pack("<Q", size), self._data_at + 8)
            os.fsync(self._file)
            # The mark is changed only after the counts are on the disk: a power failure in between leaves an
            # unfinalized file.
            os.pwrite(self._file, struct.pack("<8s", b"MDF     "), 0)
            os.pwrite(self._file, struct.pack("<HH", 0, 0), 60)
            os.fsync(self._file)
        except OSError as error:
            raise refused(self.path, error) from None
        finally:
            os.close(self._file)
