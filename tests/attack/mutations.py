"""Operators that change the bytes of any file. Each is a pure function of the random source and the content.

What knows texts stands in `texts`, what knows a format in `formats`, whose `mutated` is the one entry.
"""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Callable, Sequence

Operator = Callable[[random.Random, bytes, Sequence[bytes]], bytes]
"""(random source, content, other seeds of the target) to the changed content."""

LARGEST = 1 << 20
"""No operator makes a file longer than this [bytes]: bombs are cases of the corpus, not of chance."""

_BYTES = (0, 1, 0x7F, 0x80, 0xFE, 0xFF, 10, 13, 34, 44, 91)
_WHOLE = (0, 1, -1, 2, 127, 128, 255, 256, 32767, 65535, 1 << 20, 1 << 31, (1 << 31) - 1, (1 << 32) - 1, 1 << 62)
_REAL = (0.0, -0.0, 1e300, -1e300, 1e-320, float("nan"), float("inf"), float("-inf"), 1e15, 0.5)


def place_in(chance: random.Random, content: bytes) -> int:
    """A place in the content; headers lie at the beginning and footers at the end, so those come more often."""
    size = len(content)
    if not size:
        return 0
    which = chance.random()
    if which < 0.35:
        return chance.randrange(min(size, 512))
    if which < 0.5:
        return size - 1 - chance.randrange(min(size, 512))
    return chance.randrange(size)


def _span(chance: random.Random, content: bytes) -> tuple[int, int]:
    begin = place_in(chance, content)
    return begin, min(len(content), begin + chance.choice((1, 2, 4, 8, 16, 64, 256, 1024)))


def flip_bits(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    found = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 4, 16, 64)) if content else 0):
        found[place_in(chance, content)] ^= 1 << chance.randrange(8)
    return bytes(found)


def set_bytes(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    found = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 3, 8)) if content else 0):
        found[place_in(chance, content)] = chance.choice(_BYTES) if chance.random() < 0.7 else chance.randrange(256)
    return bytes(found)


def set_number(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A whole or real number at an aligned place becomes one at a limit."""
    kind = chance.choice(("<B", "<H", "<I", "<Q", ">H", ">I", ">Q", "<d", "<f"))
    size = struct.calcsize(kind)
    if len(content) < size:
        return content
    place = min(place_in(chance, content) // size * size, len(content) - size)
    if kind[1] in "df":
        packed = struct.pack("<d", chance.choice(_REAL))[-size:]
    else:
        packed = (chance.choice(_WHOLE) % (1 << (8 * size))).to_bytes(size, "little" if kind[0] == "<" else "big")
    return content[:place] + packed + content[place + size :]


def cut(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    return content[: place_in(chance, content)]


def drop_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    return content[:begin] + content[end:]


def repeat_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    times = chance.choice((1, 1, 2, 10, 300))
    return (content[:end] + content[begin:end] * times + content[end:])[:LARGEST]


def clear_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    return content[:begin] + bytes([chance.choice((0, 0xFF, 32))]) * (end - begin) + content[end:]


def splice(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    other = chance.choice(others) if others else content
    return content[: place_in(chance, content)] + other[place_in(chance, other) :]


BYTES: tuple[Operator, ...] = (
    flip_bits, set_bytes, set_number, set_number, cut, drop_block, repeat_block, clear_block, splice,
)  # fmt: skip


NUMBERS = (
    "0", "-0.0", "-1", "1e309", "-1e309", "1e300", "1e-400", "nan", "-nan", "inf", "-Infinity", "NaN", "1e", "--1",
    "0x7fffffffffffffff", "9" * 400, "9223372036854775808", "1_000", "1,5", "1.5.2", "+", ".", "1e999999999",
    "1" + "0" * 5000, "0b1", "١٢", "-9999999999999999999999", "3e8", "2038-01-19T03:14:08", "12:61", "1" * 310 + ".0",
)  # fmt: skip
UNITS = (
    "m**9**9**9", "m**9**9**9**9", "dB", "dBm", "N*m**-2/s", "((((m))))", "degC**2", "m/0", "1/0", "m**nan", "m**1e9",
    "kilo" * 50 + "m", "Å", "%%%", "m*" * 3000 + "m", "{}", "'", "degF", "delta_degC", "m^-1e400", "\\x1b[31m", "()",
    "m**(2**(2**(2**2)))", "-m", "+", "**", "N m", "count", "octave", "pH", "bit**64", "lambda:0", "@", "m//s", "!m",
)  # fmt: skip
TOKENS = (
    "", " ", "\0", "\x1b[2J\x1b]0;title\x07", "\x9b31m", "\r", "\u202e", "\ufeff", "\ud7ff", "\u2028", "\U0010ffff",
    "é" * 70, "'", '"', '"""', "[", "]", "[[", "]]", "{", "}", "=", "#", ",", ";", "\t", "\n", "\\", "\\u0000",
    "\\ud800", "%s%n", "{0}", "[bold]", "[/]", "__class__", "../../../../etc/passwd", "/dev/zero", "/dev/stdin", "~",
    "null", "true", "false", "." * 3000, "a." * 2000, "[" * 1500, "{" * 1500, '{"a":' * 1500, "x" * 20000, "\n" * 3000,
    "time", "Time [s]", "timestamp", "timestamp_ms", "time [ms]", "# tierod {}", "# tierod []",
    '# tierod {"channels": 5}',
)  # fmt: skip


def _words(content: bytes) -> list[tuple[int, int]]:
    """(begin, end) of words and numbers, separators apart."""
    return [found.span() for found in re.finditer(rb"[^\s,;:=\[\]{}()\"']+", content[:LARGEST])]


def _put(content: bytes, begin: int, end: int, text: str) -> bytes:
    return (content[:begin] + text.encode("utf-8", "surrogatepass") + content[end:])[:LARGEST]


def replace_word(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    words = _words(content)
    if not words:
        return content
    near = words[: chance.choice((20, 60, len(words)))]
    begin, end = chance.choice(near)
    return _put(content, begin, end, chance.choice(chance.choice((NUMBERS, UNITS, TOKENS))))


def replace_number(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    found = [each.span() for each in re.finditer(rb"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?", content[:LARGEST])]
    if not found:
        return content
    begin, end = chance.choice(found[: chance.choice((30, len(found)))])
    return _put(content, begin, end, chance.choice(NUMBERS))


def replace_unit(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    pattern = rb"(?<=\[)[^\]\n]{0,20}(?=\])|(?<=\")[\w*/%^. -]{1,12}(?=\")|(?<=[;,])(N\*m|rad|m)[^;,\n]*"
    found = [each.span() for each in re.finditer(pattern, content[:LARGEST])]
    if not found:
        return content
    begin, end = chance.choice(found)
    return _put(content, begin, end, chance.choice(UNITS))


def insert_token(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    place = place_in(chance, content)
    return _put(content, place, place, chance.choice(TOKENS))


def _lines(content: bytes) -> list[bytes]:
    return content.splitlines(keepends=True) or [b""]


def drop_line(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    lines = _lines(content)
    place = chance.randrange(min(len(lines), chance.choice((3, 10, 10000))))
    del lines[place : place + chance.choice((1, 1, 2, 20))]
    return b"".join(lines)


def drop_column(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A column of a table goes, is there twice, or is empty."""
    mark = max((b",", b";", b"\t", b" "), key=content[:2000].count)
    place, how = chance.randrange(8), chance.randrange(3)
    lines = []
    for line in content.split(b"\n"):
        cells = line.split(mark)
        if len(cells) > place:
            cells[place : place + 1] = ([], [cells[place]] * 2, [b""])[how]
        lines.append(mark.join(cells))
    return b"\n".join(lines)


def recode(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """The same text in another encoding, or with other ends of lines."""
    text = content.decode("latin-1")
    how = chance.randrange(6)
    if how == 0:
        return text.encode(chance.choice(("utf-16", "utf-16-le", "utf-32", "utf-7")))
    if how == 1:
        return b"\xef\xbb\xbf" * chance.choice((1, 2)) + content
    if how == 2:
        return content.replace(b"\n", chance.choice((b"\r\n", b"\r", b"\n\n", b"\x0b", b"")))
    if how == 3:
        return content.replace(b" ", chance.choice((b"\xa0", b"\xc2\xa0", b"\0", b"\t")))
    if how == 4:
        return content.upper() if chance.random() < 0.5 else content.lower()
    return content.replace(b".", b",")


TEXT: tuple[Operator, ...] = (
    replace_word, replace_word, replace_word, replace_number, replace_number, replace_unit, insert_token, insert_token,
    drop_line, drop_column, recode, flip_bits, set_bytes, cut, drop_block, splice,
)  # fmt: skip
