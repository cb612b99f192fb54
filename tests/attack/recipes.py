"""Files that are too large, or no files at all: made when they are needed, in less than a second each."""

from __future__ import annotations

import gzip
import os
import struct
import zlib
from pathlib import Path

UNFOLDED = 3_600_000_000
"""To which a bomb unfolds [bytes]."""

_CHUNK = 1 << 24


def pipe(path: Path) -> None:
    """A pipe into which nothing is ever written."""
    os.mkfifo(path)


def device(path: Path) -> None:
    """A link to a device that never ends."""
    path.symlink_to("/dev/zero")


def folder(path: Path) -> None:
    """A folder in place of a file."""
    path.mkdir()


def loop(path: Path) -> None:
    """A link to itself."""
    path.symlink_to(path)


def large_text(path: Path) -> None:
    """A hundred megabytes of comments above a vehicle."""
    with path.open("wb") as file:
        for _ in range(100):
            file.write((b"#" + b" " * 62 + b"\n") * (1 << 14))
        file.write(b'name = "mine"\n')


def gzip_bomb(path: Path) -> None:
    """A table of two columns, packed in members that are all alike."""
    member = gzip.compress(b"0.01,0.02\n" * (_CHUNK // 10), mtime=0)
    head = gzip.compress(b"time [s],yaw_rate [rad/s]\n", mtime=0)
    path.write_bytes(head + member * (UNFOLDED // _CHUNK))


def mat_bomb(path: Path) -> None:
    """A vector beside its time, each packed; the numbers are all zero."""
    count = UNFOLDED // 16
    elements = b"".join(_mat_vector(name, count) for name in ("t", "yaw_rate"))
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49) + elements)


def _mat_vector(name: str, count: int) -> bytes:
    label = name.encode().ljust(8, b"\0")
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIII", 5, 8, count, 1)
    head += struct.pack("<II", 1, len(name)) + label + struct.pack("<II", 9, 8 * count)
    total = 56 + 8 * count
    inner = struct.pack("<II", 14, total - 8) + head
    packed = _zeros(inner, 8 * count)
    return struct.pack("<II", 15, len(packed)) + packed


def _zeros(head: bytes, count: int) -> bytes:
    """A zlib stream of some bytes and many zeros, from one packed chunk of them."""
    first = zlib.compressobj(9, wbits=-15)
    begin = first.compress(head) + first.flush(zlib.Z_FULL_FLUSH)
    packer = zlib.compressobj(9, wbits=-15)
    chunk = packer.compress(bytes(_CHUNK)) + packer.flush(zlib.Z_FULL_FLUSH)
    rest = zlib.compressobj(9, wbits=-15)
    end = rest.compress(bytes(count % _CHUNK)) + rest.flush()
    a = zlib.adler32(head)
    low, high = a & 0xFFFF, a >> 16
    checksum = ((high + low * count) % 65521) << 16 | low
    return b"\x78\xda" + begin + chunk * (count // _CHUNK) + end + checksum.to_bytes(4, "big")


def blf_bomb(path: Path) -> None:
    """Containers that hold one object of four gigabytes, each part packed to a thousandth."""
    size = 1 << 26
    packed = _zeros(struct.pack("<4sHHII", b"LOBJ", 32, 1, 0xFFFFFFF0, 999), size - 16)
    head = struct.pack("<4sHHII", b"LOBJ", 16, 1, 32 + len(packed), 10) + struct.pack("<H6xI4x", 2, size)
    container = head + packed + bytes(len(packed) % 4)  # as python-can pads
    containers = container * (UNFOLDED // size)
    header = struct.pack(
        "<4sIBBBBBBBBQQII", b"LOGG", 144, 5, 0, 0, 0, 2, 6, 8, 1, 144 + len(containers), UNFOLDED, 0, 0
    )
    path.write_bytes(header.ljust(144, b"\0") + containers)
