"""Operators that know TOML, JSON, DBC or the text of a CAN log: the document stays one, a value in it changes."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Sequence
from typing import Any

from .texts import NUMBERS, TEXT, TOKENS, UNITS

# fmt: off
_FRAGMENTS = (
    "0", "-1", "true", '""', "[]", "{}", "nan", "inf", "-inf", "1e309", "9" * 30, "0x7fff", "2026-01-01", "07:32:00",
    '"""', "'''x'''", "[" * 700 + "]" * 700, "{a = " * 700 + "1" + "}" * 700, '"x" # y', "[1, [2, [3]]]",
    '[{kind = "step"}]', '"\\u001b[31m"', '"5 parsec"', '"1e400 s"', '"nan s"', '"-5 min"', '"m**9**9**9"',
    '"/dev/zero"', '"../x.toml"', '"."', '"~root"', "1_000.5", "[0, 1, 2]", '["a", 1]',
)
_KEYS = (
    "a." * 3000 + "b = 1", '"" = 1', "use = 'x'", "kind = 'step'", "name = 3", "[[[x]]]", "[a]\n[a]", "a = 1\na = 2",
    "[a.b.c]", '"\\u001b[2J" = 1', "values = [1e308, 1e309]", "seconds = '1e9 h'", "rate = 1e12", "count = 1e9",
    "count = 1000000000000", "sizes = []", "[thresholds.friction]\nx = 1", "[parameters.mass]\nvalue = nan",
)
_JSON: tuple[Any, ...] = (
    None, True, 0, -1, 1e308, 10**400, float("nan"), float("inf"), "", "x" * 5000, "\x1b[31m", [], {}, [[]], {"a": {}},
    "\ud800", 2**63, 0.1, "2026", [None] * 50, -(2**31), "nan",
)
_HEX = ("FFFFFFFF", "1FFFFFFFFFF", "0", "-1", "7FF", "80000000", "FFFFFFFFFFFFFFFFFFFF", "G", "0x10", "1FFFFFFFx")
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


def toml_key(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A key more, of another name, in another table."""
    lines = content.split(b"\n")
    place = chance.randrange(len(lines))
    how = chance.randrange(4)
    if how == 0 and b"=" in lines[place]:
        lines[place] = (
            chance.choice(TOKENS + _FRAGMENTS).encode("utf-8", "surrogatepass")
            + b" ="
            + lines[place].partition(b"=")[2]
        )
    elif how == 1:
        tables = [at for at, line in enumerate(lines) if line.startswith(b"[")]
        if tables:
            name = chance.choice(
                ("[x]", "[[x]]", "[parameters]", "[[faults]]", "[signals.x]", "[channels]", "[sensors]")
            )
            lines[chance.choice(tables)] = name.encode()
    else:
        lines.insert(place, chance.choice(_KEYS).encode())
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


def hexadecimal(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """An identifier or a byte of a CAN log."""
    words = [each.span() for each in re.finditer(rb"\b[0-9A-Fa-f]{2,8}\b", content)]
    if not words:
        return content
    begin, end = chance.choice(words[: chance.choice((20, len(words)))])
    return content[:begin] + chance.choice(_HEX).encode() + content[end:]


def dbc_signal(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """Position, length, factor or range of a signal, or the identifier of a message."""
    spots = [each.span() for each in re.finditer(rb"(?<=[|:@(,\[ ])-?\d+(\.\d+)?(?=[|@+\-,)\]: ])", content)]
    if not spots:
        return content
    begin, end = chance.choice(spots)
    values = (
        "0",
        "-1",
        "1",
        "63",
        "64",
        "65",
        "512",
        "4096",
        "1e300",
        "nan",
        "4294967295",
        "2147483648",
        "1e-400",
        "9" * 30,
    )
    return content[:begin] + chance.choice(values).encode() + content[end:]
