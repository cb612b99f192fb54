"""Operators that change the bytes of any file. Each is a pure function of the random source and the content.

What knows texts stands in `texts`, what knows a format in `formats`, whose `mutated` is the one entry.
"""

from __future__ import annotations

import random
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


def step_number(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    """A length or offset becomes a little more or less."""
    size = chance.choice((1, 2, 4, 8))
    if len(content) < size:
        return content
    place = min(place_in(chance, content) // size * size, len(content) - size)
    value = int.from_bytes(content[place : place + size], "little") + chance.choice((-8, -2, -1, 1, 2, 8, 1000))
    return content[:place] + (value % (1 << (8 * size))).to_bytes(size, "little") + content[place + size :]


def cut(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    return content[: place_in(chance, content)]


def cut_beginning(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    return content[chance.choice((1, 2, 4, 16, 64, place_in(chance, content))) :]


def drop_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    return content[:begin] + content[end:]


def repeat_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    times = chance.choice((1, 1, 2, 10, 300))
    return (content[:end] + content[begin:end] * times + content[end:])[:LARGEST]


def swap_blocks(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    (a, b), (c, d) = sorted((_span(chance, content), _span(chance, content)))
    return content if b > c else content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def clear_block(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    begin, end = _span(chance, content)
    return content[:begin] + bytes([chance.choice((0, 0xFF, 32))]) * (end - begin) + content[end:]


def splice(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    other = chance.choice(others) if others else content
    return content[: place_in(chance, content)] + other[place_in(chance, other) :]


def insert_random(chance: random.Random, content: bytes, others: Sequence[bytes]) -> bytes:
    place = place_in(chance, content)
    return content[:place] + chance.randbytes(chance.choice((1, 3, 16, 200))) + content[place:]


BYTES: tuple[Operator, ...] = (
    flip_bits, set_bytes, set_number, set_number, step_number, cut, cut_beginning, drop_block, repeat_block,
    swap_blocks, clear_block, splice, insert_random,
)  # fmt: skip
