"""Operators that know TOML, JSON, DBC or the text of a CAN log: the document stays one, a value in it changes."""

from __future__ import annotations

import json
import random
import re
import struct
import zlib
from collections.abc import Sequence
from typing import Any

from .mutations import BYTES, NUMBERS, TEXT, TOKENS, UNITS, Operator

# fmt: off
_FRAGMENTS = (
    "0", "-1", "true", '""', "[]", "{}", "nan", "inf", "-inf", "1e309", "9" * 30, "0x7fff", "2026-01-01", "07:32:00",
    '"""', "'''x'''", "[" * 700 + "]" * 700, "{a = " * 700 + "1" + "}" * 700, '"x" # y', "[1, [2, [3]]]",
    '[{kind = "step"}]', '"\\u001b[31m"', '"5 parsec"', '"1e400 s"', '"nan s"', '"-5 min"', '"m**9**9**9"',
    '"/dev/zero"', '"../x.toml"', '"."', '"~root"', "1_000.5", "[0, 1, 2]", '["a", 1]',
)
_JSON: tuple[Any, ...] = (
    None, True, 0, -1, 1e308, 10**400, float("nan"), float("inf"), "", "x" * 5000, "\x1b[31m", [], {}, [[]], {"a": {}},
    "\ud800", 2**63, 0.1, "2026", [None] * 50, -(2**31), "nan",
)
# fmt: on


def toml_value(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A value becomes one of another type, or out of every range."""
    lines = content.split(b"\n")
    keyed = [place for place, line in enumerate(lines) if re.match(rb"\s*[\w.\"-]+\s*=", line)]
    if not keyed:
        return content
    place = chance.choice(keyed)
    key, _, value = lines[place].partition(b"=")
    how = chance.random()
    if how < 0.5:
        text = chance.choice(_FRAGMENTS)
    elif how < 0.75:
        text = chance.choice(NUMBERS)
    elif how < 0.9:
        text = json.dumps(chance.choice(UNITS + TOKENS).replace("\ud7ff", ""))
    else:
        number = re.search(r"[\d.eE+-]+", value.decode("utf-8", "replace"))
        text = value.decode("utf-8", "replace").replace(number[0], chance.choice(NUMBERS)) if number else "0"
    lines[place] = key + b"= " + text.encode("utf-8", "surrogatepass")
    return b"\n".join(lines)


def json_node(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A value of a document becomes another one, goes, or gets another name; a digest in it is made anew."""
    try:
        document = json.loads(content)
    except (ValueError, RecursionError):
        return chance.choice(TEXT)(chance, content, others)
    for _ in range(chance.choice((1, 1, 2))):
        document = _changed(chance, document)
    if isinstance(document, dict) and "digest" in document and chance.random() < 0.8:
        from tierod.diagnosis.store import digest_of

        try:
            document["digest"] = digest_of(document.get("content"), document.get("vehicle"))
        except (ValueError, TypeError):  # a lone surrogate, which UTF-8 does not hold
            document["digest"] = ""
    try:
        return json.dumps(document).encode()
    except ValueError:  # a part was put into itself
        return content


def _changed(chance: random.Random, node: Any, depth: int = 0) -> Any:
    if isinstance(node, dict | list) and node and (not depth or chance.random() < 0.75):
        keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        key, how = chance.choice(keys), chance.random()
        if how < 0.06 and depth:
            del node[key]
        elif how < 0.1 and isinstance(node, dict) and depth:
            node[chance.choice(TOKENS[:20])] = node.pop(key)
        else:
            node[key] = _changed(chance, node[key], depth + 1)
        return node
    return chance.choice(_JSON)


def mdf_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Of a block of MDF 4 the length, the number of links, a link, a field or the name."""
    places = [found.start() for found in re.finditer(rb"##[A-Z]{2}\0{4}", content)]
    if not places:
        return chance.choice(BYTES)(chance, content, others)
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
            table = table.set_column(
                place,
                name,
                pa.array([chance.choice((str, lambda each: [each]))(each) for each in table[name].to_pylist()]),
            )
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


FAMILIES: dict[str, tuple[tuple[Operator, ...], tuple[Operator, ...]]] = {
    "text": (TEXT, TEXT),
    "can-text": (TEXT, TEXT),
    "gzip": (BYTES, BYTES),
    "mdf": (BYTES, (mdf_block,)),
    "parquet": (BYTES, (parquet_footer, parquet_table, parquet_table)),
    "process": (BYTES, BYTES),
    "mat": (BYTES, BYTES),
    "blf": (BYTES, (blf_container,)),
    "toml": (TEXT, (toml_value,)),
    "json": (TEXT, (json_node,)),
    "dbc": (TEXT, TEXT),
}
"""Of each family of formats the operators that know nothing of it, and those that do."""


def mutated(chance: random.Random, content: bytes, others: Sequence[bytes], family: str) -> bytes:
    """A changed file: mostly one change, now and then a handful."""
    plain, aware = FAMILIES[family]
    # A text that is no longer TOML or JSON ends at the parser: most changes keep it one.
    share = 0.8 if family in ("toml", "json", "dbc") else 0.6
    for _ in range(chance.choice((1, 1, 1, 1, 2, 2, 3, 6))):
        content = chance.choice(aware if chance.random() < share else plain)(chance, content, others)
    return content
