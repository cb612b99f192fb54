"""Text of `candump -L`, parsed as arrays.

Lines with their parts at the same positions (of the same `Make`) form one rectangular table of characters, which is
then converted column by column; a log has a few dozen makes, whatever its length.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.content import whole_lines
from tierod.io.readers.frames import EXTENDED, Frames, bus_number, taken
from tierod.io.readers.log import Log
from tierod.io.readers.source import Format, text_begin

# Pattern of the beginning of a line of `candump -L`
LINE = re.compile(rb"^\(\d+\.\d+\) +\S+ +[0-9A-Fa-f]{3,8}#", re.MULTILINE)

_HEX = np.full(256, 255, dtype=np.uint8)
for _digits, _least in ((b"0123456789", 0), (b"ABCDEF", 10), (b"abcdef", 10)):
    _HEX[list(_digits)] = np.arange(_least, _least + len(_digits))

_DIGITS = 20  # Largest number of digits of the seconds and of their fraction; more are no time

_MARK, _DOT, _CLOSE, _SPACE, _OPEN = b"#.) ("
_ERROR_FRAME, _ID = 0x20000000, 0x1FFFFFFF


class Make(NamedTuple):
    """Positions of the parts of a line: "(12.34) can0 123#0102" has dot 3, close 6, space 12, mark 16, length 21."""

    dot: int
    close: int
    space: int
    mark: int
    length: int
    flexible: int

    @property
    def data(self) -> int:
        """Position at which the payload begins; for flexible data rate after "##" and its flags."""
        return self.mark + 3 if self.flexible else self.mark + 1

    @property
    def possible(self) -> bool:
        """Whether a line of this make can be a frame with data."""
        ordered = 1 < self.dot < self.close < self.space < self.mark and 3 <= self.mark - self.space - 1 <= 8
        size = self.length - self.data
        ordered = ordered and self.dot <= _DIGITS and self.close - self.dot <= _DIGITS
        return ordered and 0 <= size <= 128 and size % 2 == 0


class Part(NamedTuple):
    """The frames of one make, and the numbers of their lines."""

    lines: np.ndarray
    seconds: np.ndarray
    fraction: np.ndarray
    identifier: np.ndarray
    bus: np.ndarray
    payload: np.ndarray
    length: np.ndarray


def frames_of(blocks: Iterable[bytes]) -> Iterator[Frames]:
    """The frames of a log, block by block, their time counted from the first; the last has the note on broken lines.

    Args:
        blocks: blocks of whole lines; the tables of a block take about ten times as much memory
    """
    names: dict[bytes, int] = {}
    first: tuple[float, float] | None = None
    lines = good = 0
    frames: Frames | None = None
    for block in blocks:
        parts, count, without = _parsed(np.frombuffer(block, dtype=np.uint8), names)
        lines, good = lines + count, good + without
        if parts:
            whole = _ordered(parts)
            good += len(whole.lines)
            first = first or (float(whole.seconds[0]), float(whole.fraction[0]))
            frames = _frames(whole, first, tuple(name.decode("latin-1") for name in names))
            yield frames
    if frames is None:
        raise InputError(
            "the log holds no CAN frame as `candump -L` writes it, (seconds) interface id#data; record it so"
        )
    if lines > good:
        broken = f"{lines - good} of {lines} lines of the log are broken and were left out"
        yield replace(taken(frames, slice(0, 0)), notes=(broken,))


def _parsed(text: np.ndarray, names: dict[bytes, int]) -> tuple[list[Part], int, int]:
    """(frames by make, number of lines, number of whole lines without a signal)."""
    starts, ends = _lines(text)
    parts, passed = [], 0
    for make, members in _alike(_makes(text, starts, ends)):
        table = text[starts[members][:, None] + np.arange(make.length)]
        passed += int(np.count_nonzero(_without_data(table, make)))
        if make.possible:
            parts.append(_part(table, make, members, names))
    return [part for part in parts if len(part.lines)], len(starts), passed


def _lines(text: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end of every line that is not empty, without line end and direction (" R", " T") at its end."""
    ends = np.flatnonzero(text == 10)
    if len(text) and (not len(ends) or ends[-1] != len(text) - 1):
        ends = np.append(ends, len(text))
    starts = np.concatenate(([0], ends[:-1] + 1)) if len(ends) else ends
    carriage = (ends > starts) & (text[np.maximum(ends - 1, 0)] == 13)
    ends = ends - carriage
    direction = (ends - starts > 2) & (text[np.maximum(ends - 2, 0)] == _SPACE)
    ends = ends - 2 * direction
    full = ends > starts
    return starts[full], ends[full]


def _makes(text: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The make of every line, shape (n, 6); -1 for a part that is missing."""
    dot, close, mark = (_first(text, starts, ends, code, 0) for code in (_DOT, _CLOSE, _MARK))
    space = _first(text, starts, ends, _SPACE, 1)
    after = text[np.minimum(starts + mark + 1, len(text) - 1)] if len(text) else mark
    flexible = (mark >= 0) & (after == _MARK) & (starts + mark + 1 < ends)
    opened = text[starts] == _OPEN
    makes = np.stack([np.where(opened, dot, -1), close, space, mark, ends - starts, flexible], axis=1)
    # Positions beyond those of any frame are cut: `_alike` packs all six into one integer, nine bits each.
    return np.asarray(np.minimum(makes, 400))


def _first(text: np.ndarray, starts: np.ndarray, ends: np.ndarray, code: int, skip: int) -> np.ndarray:
    """Position of a character within each line, after `skip` earlier ones; -1 where it is absent."""
    at = np.flatnonzero(text == code)
    if not len(at):
        return np.full(len(starts), -1)
    nth = np.searchsorted(at, starts) + skip
    found = at[np.minimum(nth, len(at) - 1)]
    return np.where((nth < len(at)) & (found < ends), found - starts, -1)


def _alike(makes: np.ndarray) -> list[tuple[Make, np.ndarray]]:
    """(make, numbers of its lines) of all lines that have all parts."""
    keys = np.zeros(len(makes), dtype=np.int64)
    for column in makes.T:
        keys = keys * 512 + column + 1
    rows = np.flatnonzero((makes[:, :5] > 0).all(axis=1))
    groups = []
    for key in np.unique(keys[rows]).tolist():
        members = rows[keys[rows] == key]
        groups.append((Make(*makes[members[0]].tolist()), members))
    return groups


def _without_data(table: np.ndarray, make: Make) -> np.ndarray:
    """Mask of the lines that are remote frames or error frames: whole, but without a signal."""
    if make.length <= make.mark + 1 or make.flexible:
        return np.zeros(len(table), dtype=bool)
    remote = table[:, make.mark + 1] == ord("R")
    return np.asarray(remote | _is_error(_HEX[table[:, make.space + 1 : make.mark]]))


def _is_error(digits: np.ndarray) -> np.ndarray:
    if digits.shape[1] != 8:
        return np.zeros(len(digits), dtype=bool)
    return np.asarray((digits < 16).all(axis=1) & ((digits[:, 0] & (_ERROR_FRAME >> 28)) != 0))


def _part(table: np.ndarray, make: Make, members: np.ndarray, names: dict[bytes, int]) -> Part:
    digits = _HEX[table]
    decimal = np.r_[1 : make.dot, make.dot + 1 : make.close]
    hexadecimal = np.r_[make.space + 1 : make.mark, make.data : make.length]
    good = (digits[:, decimal].max(axis=1) < 10) & (digits[:, hexadecimal].max(axis=1) < 16)
    good &= ~_without_data(table, make)
    if not good.all():
        table, digits, members = table[good], digits[good], members[good]
    places = make.close - make.dot - 1
    wide = make.mark - make.space - 1 > 3
    identifier = _number(digits[:, make.space + 1 : make.mark], 16.0).astype(np.uint32) & np.uint32(_ID)
    payload = digits[:, make.data : make.length]
    return Part(
        members,
        _number(digits[:, 1 : make.dot], 10.0),
        _number(digits[:, make.dot + 1 : make.close], 10.0) / 10.0**places,
        identifier | np.uint32(EXTENDED if wide else 0),
        _buses(table[:, make.close + 2 : make.space], names),
        (payload[:, ::2] << 4) | payload[:, 1::2],
        np.full(len(members), (make.length - make.data) // 2),
    )


def _number(digits: np.ndarray, base: float) -> np.ndarray:
    """Numbers from digits, the highest digit first; exact to 2**53."""
    return digits.astype(float) @ base ** np.arange(digits.shape[1] - 1, -1, -1.0)


def _buses(table: np.ndarray, names: dict[bytes, int]) -> np.ndarray:
    """The number of the bus of every row, from its name's characters."""
    numbers = np.zeros(len(table), dtype=np.uint16)
    left = np.arange(len(table))
    while len(left):
        name = table[left[0]].tobytes()
        same = (table[left] == table[left[0]]).all(axis=1)
        numbers[left[same]] = bus_number(names, name)
        left = left[~same]
    return numbers


def _joined(parts: list[Part]) -> Part:
    width = max(part.payload.shape[1] for part in parts)
    wide = [part._replace(payload=np.pad(part.payload, ((0, 0), (0, width - part.payload.shape[1])))) for part in parts]
    return Part(*(np.concatenate(column) for column in zip(*wide, strict=True)))


def _ordered(parts: list[Part]) -> Part:
    together = _joined(parts)
    put = np.argsort(together.lines, kind="stable")
    return Part(*(column[put] for column in together))


def _frames(part: Part, first: tuple[float, float], buses: tuple[str, ...]) -> Frames:
    """The frames of a block, their time counted from the seconds and the fraction of the first frame of the log."""
    # Seconds and fraction are subtracted apart, so that the large calendar time takes no digit of the fraction.
    time = (part.seconds - first[0]) + (part.fraction - first[1])
    return Frames(time, part.identifier, part.bus, part.payload, part.length, buses, first[0] + first[1])


FORMAT = Format(
    "candump",
    "candump -L (.log)",
    (".log",),
    lambda content, time: Log(content.path.name, lambda: [frames_of(whole_lines(content.blocks(), content.path))]),
    lambda head, ending: LINE.search(text_begin(head)) is not None,
    text=True,
)
