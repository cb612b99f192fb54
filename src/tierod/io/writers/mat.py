"""MATLAB 5: a vector "time" with the signals, or one structure of these per group of channels with common stamps."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import IO

from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.io.layout import Writer
from tierod.io.writers.spool import ROWS, FromSpool, Spool, SpooledGroup

_MATRIX, _DOUBLE_CLASS, _STRUCT_CLASS, _CHAR_CLASS = 14, 6, 2, 4
_INT8, _UINT16, _INT32, _UINT32, _DOUBLE = 1, 4, 5, 6, 9
_LONGEST = 63
"""Largest number of characters of a name in MATLAB."""

_LARGEST = 2**31 - 1024
"""Largest size of a variable in a MATLAB 5 file [bytes]."""

UNITS = "units"
"""Name of the structure of texts with the unit of every vector."""


def write_mat(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to a file for MATLAB's `load`, not packed.

    Args:
        spool: the recording
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold

    Raises:
        OutputError: nothing to write, a variable is too long for the format, or the file cannot be written
    """
    found = spool.groups()
    names = _names(list(spool.channels))
    lost = ["MATLAB 5 holds units (in the structure 'units'), but no sources, notes or calendar time"]
    renamed = [f"{name} is {names[name]}" for name in spool.channels if names[name] != name]
    if renamed:
        lost.append(f"names that MATLAB does not allow were changed: {', '.join(renamed[:6])}")
    with replacing(path) as temporary, temporary.open("wb") as file:
        file.write(b"MATLAB 5.0 MAT-file, written by tierod".ljust(116) + bytes(8) + b"\x00\x01IM")
        for number, group in enumerate(found):
            if len(found) == 1:
                _vector(file, "time", group, -1)
                for place, channel in enumerate(group.channels):
                    _vector(file, names[channel.name], group, place)
            else:
                _structure(file, f"group{number + 1}", group, [names[each.name] for each in group.channels])
        _texts(file, UNITS, {names[name]: each.unit for name, each in spool.channels.items()})
    return tuple(lost)


def _names(given: list[str]) -> dict[str, str]:
    """A name that MATLAB allows for every channel: unique, and different from "time" and "units"."""
    taken, found = {"time", UNITS}, {}
    for name in given:
        base = re.sub(r"[^A-Za-z0-9_]", "_", name)[:_LONGEST]
        base = base if base[:1].isalpha() else f"x{base}"[:_LONGEST]
        free = (base, *(f"{base[: _LONGEST - 7]}_{number}" for number in range(2, len(given) + 4)))
        found[name] = next(each for each in free if each not in taken)
        taken.add(found[name])
    return found


def _element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def _head(name: str, rows: int, columns: int, kind: int) -> bytes:
    flags = _element(_UINT32, struct.pack("<II", kind, 0))
    return flags + _element(_INT32, struct.pack("<ii", rows, columns)) + _element(_INT8, name.encode())


def _vector(file: IO[bytes], name: str, group: SpooledGroup, place: int) -> None:
    """Write the time (place -1) or a channel of a group as a column of doubles."""
    head, size = _head(name, group.count, 1, _DOUBLE_CLASS), 8 * group.count
    if size > _LARGEST:
        raise OutputError(f"'{name}' has {group.count} samples, more than a MATLAB 5 file holds; write Parquet or MF4")
    file.write(struct.pack("<II", _MATRIX, len(head) + 8 + size) + head + struct.pack("<II", _DOUBLE, size))
    for begin in range(0, group.count, ROWS):
        part = group.time(begin, begin + ROWS) if place < 0 else group.values(begin, begin + ROWS)[place]
        file.write(part.tobytes())


def _structure(file: IO[bytes], name: str, group: SpooledGroup, names: list[str]) -> None:
    fields = ["time", *names]
    head = _struct_head(name, fields)
    each = 8 + len(_head("", group.count, 1, _DOUBLE_CLASS)) + 8 + 8 * group.count
    size = len(head) + len(fields) * each
    # Only the 32 bits of its size limit a structure; its vectors are checked one by one.
    if size > 2 * _LARGEST:
        raise OutputError(f"'{name}' takes {size / 1e9:.3g} GB, more than a MATLAB 5 file holds; write Parquet or MF4")
    file.write(struct.pack("<II", _MATRIX, size) + head)
    for place in range(-1, len(names)):
        _vector(file, "", group, place)


def _struct_head(name: str, fields: list[str]) -> bytes:
    text = b"".join(field.encode().ljust(_LONGEST + 1, b"\0") for field in fields)
    length = struct.pack("<HHi", _INT32, 4, _LONGEST + 1)
    return _head(name, 1, 1, _STRUCT_CLASS) + length + _element(_INT8, text)


def _texts(file: IO[bytes], name: str, values: dict[str, str]) -> None:
    body = _struct_head(name, list(values))
    for text in values.values():
        encoded = text.encode("utf-16-le")
        inner = _head("", 1 if text else 0, len(encoded) // 2, _CHAR_CLASS) + _element(_UINT16, encoded)
        body += struct.pack("<II", _MATRIX, len(inner)) + inner
    file.write(struct.pack("<II", _MATRIX, len(body)) + body)


WRITER = Writer("MATLAB 5", FromSpool(write_mat))
