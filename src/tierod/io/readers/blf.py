"""The packed containers of a BLF file, unpacked within limits before python-can reads them."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

from tierod.io.readers.content import Content
from tierod.io.readers.limits import Allowance

_SIZE_OF_FILE = 16
"""Offset of the size of the whole file [bytes] in the header."""

_HEADER = struct.Struct("<4sHHII")
"""Signature, size and version of the header, size of the object with header, type."""

_CONTAINER = struct.Struct("<HxxxxxxIxxxx")
"""Compression method and unpacked size, before the content."""

_CONTAINER_TYPE, _PLAIN, _ZLIB = 10, 0, 2


def unpacked(content: Content) -> Iterator[bytes]:
    """The bytes of a BLF file with every packed container replaced by one that is not packed.

    Raises:
        InputError: a container or the whole unfolds to more than is allowed
    """
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
            padding = stream.read(size % 4)
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
    """The objects in consecutive containers, one of which may begin in one and end in the next.

    python-can looks for the next object where the size of the one before says, and never ends where that is no size.

    Args:
        allowance: of the file
    """

    def __init__(self, allowance: Allowance):
        self._allowance, self._rest = allowance, b""

    def add(self, plain: bytes) -> None:
        """The content of the next container.

        Raises:
            ValueError: an object is shorter than its header
            InputError: an object is longer than is allowed
        """
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
    """The content of a container; that of a damaged one as far as it goes."""
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
    """A note where a BLF file is shorter than its header says, since its reader ends there without a word; else ""."""
    head = content.head(_SIZE_OF_FILE + 8)
    size = int.from_bytes(head[_SIZE_OF_FILE:], "little")
    there = sum(map(len, content.blocks())) if content.packed else content.size
    return "" if there >= size else f"the log is cut off: {there} of {size} bytes are there; copy it again for the rest"
