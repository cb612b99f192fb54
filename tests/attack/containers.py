"""Operators that know a binary format: its frame stays whole, so that what is wrong lies below the first check."""

from __future__ import annotations

import gzip
import random
import re
import struct
import zlib
from collections.abc import Sequence
from typing import Any

from .documents import json_node
from .mutations import BYTES
from .texts import NUMBERS, TEXT, TOKENS


def mdf_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Of a block of MDF 4 the length, the number of links, a link, a field or the name."""
    places = [found.start() for found in re.finditer(rb"##[A-Z]{2}\0{4}", content)]
    if not places:
        return old_block(chance, content, others)
    place, found = chance.choice(places), bytearray(content)
    length, links = struct.unpack_from("<QQ", content, place + 8) if place + 24 <= len(content) else (24, 0)
    size, links = min(length, len(content) - place), min(links, 64)
    fields = place + 24 + 8 * links
    how = chance.randrange(6)
    if how == 0:
        _store(
            found, place + 8, chance.choice((0, 1, 23, 24, length - 8, length + 8, length * 2, 1 << 31, (1 << 63) + 1))
        )
    elif how == 1:
        _store(found, place + 16, chance.choice((0, 1, links + 1, max(links - 1, 0), 255, 1 << 32, (1 << 64) - 1)))
    elif how == 2 and links:
        goal = chance.choice(
            (0, place, 64, len(content), len(content) - 8, 1 << 40, *chance.sample(places, 1), place + 1)
        )
        _store(found, place + 24 + 8 * chance.randrange(links), goal)
    elif how == 3 and size > fields - place:
        found[chance.randrange(fields, place + size)] = chance.choice((0, 1, 2, 4, 7, 8, 16, 64, 127, 128, 255))
    elif how == 4:
        found[place + 2 : place + 4] = chance.choice((b"DT", b"DZ", b"DL", b"HL", b"CN", b"CC", b"TX", b"SD", b"??"))
    elif size > fields - place:
        begin = chance.randrange(fields, place + size)
        width = chance.choice((2, 4, 8))
        found[begin : begin + width] = chance.choice((b"\xff" * width, b"\0" * width, b"\0" * (width - 1) + b"\x80"))
    return bytes(found)


def _store(found: bytearray, place: int, value: int) -> None:
    found[place : place + 8] = (value % (1 << 64)).to_bytes(8, "little")


def old_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Of a block of MDF 3 a byte of its fields."""
    places = [found.start() for found in re.finditer(rb"(HD|DG|CG|CN|CC|TX|PR)[\x04-\xff][\0-\x03]", content)]
    found = bytearray(content)
    for _ in range(chance.choice((1, 2)) if places else 0):
        at = chance.choice(places) + chance.randrange(2, 64)
        if at < len(found):
            found[at] = chance.choice((0, 1, 2, 127, 128, 254, 255))
    return bytes(found)


def parquet_footer(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Bytes of the footer, or its length; the marks stay."""
    if len(content) < 16:
        return content
    size = int.from_bytes(content[-8:-4], "little")
    begin = max(4, len(content) - 8 - size)
    if chance.random() < 0.15:
        goal = chance.choice((0, 1, size - 1, size + 1, 2 * size, (1 << 31) - 1, (1 << 32) - 1))
        return content[:-8] + (goal % (1 << 32)).to_bytes(4, "little") + content[-4:]
    footer = chance.choice(BYTES)(chance, content[begin:-8], ())
    return content[:begin] + footer + len(footer).to_bytes(4, "little") + content[-4:]


def parquet_data(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Bytes of the pages; the footer stays."""
    size = int.from_bytes(content[-8:-4], "little")
    begin = len(content) - 8 - size
    if begin < 8:
        return content
    found = bytearray(content)
    for _ in range(chance.choice((1, 2, 4, 16))):
        found[chance.randrange(4, begin)] = chance.randrange(256)
    return bytes(found)


def parquet_table(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A whole file whose columns have other types, names, values or notes."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(pa.BufferReader(content))
        place = chance.randrange(table.num_columns)
        name, how = table.column_names[place], chance.randrange(5)
        if how == 0:
            names = list(table.column_names)
            names[place] = chance.choice(TOKENS + NUMBERS).replace("\ud7ff", "")
            table = table.rename_columns(names)
        elif how == 1:
            table = table.set_column(place, name, _other_type(chance, pa, table[name]))
        elif how == 2:
            values = table[name].to_pylist()
            for _ in range(chance.choice((1, 5, len(values)))):
                values[chance.randrange(len(values))] = chance.choice(
                    (None, 1e300, float("nan"), float("inf"), -1.0, 0.0)
                )
            table = table.set_column(place, name, pa.array(values, pa.float64()))
        elif how == 3:
            notes = {
                key: chance.choice((json_node, *TEXT))(chance, value, ())
                for key, value in (table.schema.metadata or {b"tierod": b"{}"}).items()
            }
            table = table.replace_schema_metadata(notes)
        else:
            rows = [chance.randrange(table.num_rows) for _ in range(chance.choice((0, 1, 2, table.num_rows)))]
            table = table.take(rows)
        sink = pa.BufferOutputStream()
        pq.write_table(table, sink, row_group_size=chance.choice((1, 7, 1000)))
    except (pa.ArrowException, OSError, ValueError, TypeError, OverflowError):
        return chance.choice(BYTES)(chance, content, others)
    return sink.getvalue().to_pybytes()


def _other_type(chance: random.Random, pa: Any, column: Any) -> Any:
    """The column as another type, where its values allow; else lists, texts, structures of them."""
    values = column.to_pylist()
    how = chance.randrange(8)
    if how < 4:
        kinds = (
            pa.int8(),
            pa.timestamp("s"),
            pa.timestamp("ns", "Asia/Tokyo"),
            pa.float16(),
            pa.duration("us"),
            pa.date32(),
        )
        kind = chance.choice(kinds)
        whole = [0 if each is None else int(each) for each in values]
        return pa.array(whole, pa.int32() if kind == pa.date32() else pa.int64()).cast(kind, safe=False)
    made = (
        [str(each) for each in values],
        [[each] for each in values],
        [{"x": each} for each in values],
        [None] * len(values),
    )
    array = pa.array(made[how - 4])
    return array.dictionary_encode() if how == 4 and chance.random() < 0.5 else array


def gzip_content(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """What is packed changes, or how it is packed."""
    try:
        inner = gzip.decompress(content)
    except (OSError, EOFError, zlib.error):
        return chance.choice(BYTES)(chance, content, others)
    how = chance.randrange(6)
    if how == 0:
        half = len(inner) // 2
        return gzip.compress(inner[:half], mtime=0) + gzip.compress(inner[half:], mtime=0)
    if how == 1:
        return content + chance.choice((b"\0" * 64, b"tail", content[:20], gzip.compress(b"", mtime=0)))
    if how == 2:
        return gzip.compress(content, mtime=0)
    return gzip.compress(chance.choice(TEXT)(chance, inner, ()), mtime=0)


def mat_element(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Type or size of an element, or what is packed in one."""
    place = 128
    if len(content) >= 136 and content[128] == 15 and chance.random() < 0.8:
        elements = []
        while place + 8 <= len(content):
            size = int.from_bytes(content[place + 4 : place + 8], "little")
            elements.append((place, size))
            place += 8 + size
        place, size = chance.choice(elements)
        try:
            inner = zlib.decompress(content[place + 8 : place + 8 + size])
        except zlib.error:
            return chance.choice(BYTES)(chance, content, others)
        packed = zlib.compress(chance.choice(BYTES)(chance, inner, ()))
        head = content[place : place + 4] + len(packed).to_bytes(4, "little")
        return content[:place] + head + packed + content[place + 8 + size :]
    if len(content) < 144:
        return content
    found = bytearray(content)
    at = 128 + 4 * chance.randrange((min(len(content), 1200) - 132) // 4)
    found[at : at + 4] = chance.choice(
        (0, 1, 5, 6, 9, 14, 15, 17, 255, 1 << 16, (1 << 31) - 1, (1 << 32) - 1)
    ).to_bytes(4, "little")
    return bytes(found)


def blf_container(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """What is packed in a container, or a field of its header."""
    place = content.find(b"LOBJ")
    if place < 0 or place + 32 > len(content):
        return chance.choice(BYTES)(chance, content, others)
    if chance.random() < 0.4:
        found = bytearray(content)
        at = place + chance.randrange(4, 32)
        found[at] = chance.choice((0, 1, 2, 10, 127, 128, 255))
        return bytes(found)
    size = int.from_bytes(content[place + 8 : place + 12], "little")
    try:
        inner = zlib.decompress(content[place + 32 : place + size])
    except zlib.error:
        return chance.choice(BYTES)(chance, content, others)
    packed = zlib.compress(chance.choice(BYTES)(chance, inner, ()))
    head = bytearray(content[place : place + 32])
    head[8:12] = (32 + len(packed)).to_bytes(4, "little")
    return content[:place] + bytes(head) + packed + content[place + size :]
