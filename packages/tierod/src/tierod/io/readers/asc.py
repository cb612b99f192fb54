"""CAN logs in Vector's text format (ASC): frames with data, whatever their time stamps count from."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.content import whole_lines
from tierod.io.readers.frames import EXTENDED, IDENTIFIERS, Frames, Log, Remembered, bus_number, only_notes, stacked
from tierod.io.readers.source import Format, text_begin

_BASE = re.compile(rb"base\s+(hex|dec)\b(?:\s+timestamps\s+(absolute|relative))?", re.IGNORECASE)
_DATE = re.compile(rb"(?:date|begin\s+triggerblock)\s+(?:\w+\.?\s+)?(.+)", re.IGNORECASE)
_TEXT = re.compile(rb"//|date\b|base\b|(?:no\s+)?internal\s+events|begin\b|end\b", re.IGNORECASE)
_STAMP = re.compile(rb"[+-]?\d{1,15}(?:\.\d{1,15})?")
# Beginning of the events that hold no data of a frame
_EVENT = re.compile(
    rb"(?:can\s+)?(?:\d+\s+)?(?:errorframe|overloadframe|statistic|status|j1939tp)|canfd\s+\d+\s+\w+\s+errorframe|"
    rb"canfd\s+\d+\s+(?:errorframe|statistic)|start\s+of\s+measurement|end\s+of\s+measurement|log\b|sv:|comment\b",
    re.IGNORECASE,
)

# Beginnings of the names of the months in English and German
_MONTHS = (
    ("jan",), ("feb",), ("mar", "mär", "mrz"), ("apr",), ("may", "mai"), ("jun",), ("jul",), ("aug",), ("sep",),
    ("oct", "okt"), ("nov",), ("dec", "dez"),
)  # fmt: skip

_WRITTEN = re.compile(r"(\w+)\s+(\d{1,2})\s+(\d{1,2}):(\d\d):(\d\d)(\.\d+)?\s*([ap]m)?\s+(\d{4})", re.IGNORECASE)

_SIZES = (*range(9), 12, 16, 20, 24, 32, 48, 64)  # Number of bytes by the data length code of CAN FD (ISO 11898-1)

# What is left out and counted
WIDE, UNREAD = "frames with an identifier of more than 29 bits", "lines that hold no CAN frame"


@dataclass
class _Block:
    time: list[float] = field(default_factory=list)
    identifier: list[int] = field(default_factory=list)
    bus: list[int] = field(default_factory=list)
    payload: list[bytes] = field(default_factory=list)


class _Lines:
    """Reads a log line by line; keeps what earlier lines say about the later ones.

    `begin` is the calendar time from which the stamps count [s], None before a date; `left_out` counts lines.
    """

    def __init__(self) -> None:
        self.begin: float | None = None
        self.left_out: Counter[str] = Counter()
        self.buses: dict[str, int] = {}
        self._base, self._relative = 16, False
        self._now = self._offset = 0.0
        self._trigger: float | None = None
        self._events = 0

    def block(self, lines: Iterable[bytes]) -> _Block:
        made = _Block()
        for line in lines:
            words = line.split()
            if not words:
                continue
            if not _STAMP.fullmatch(words[0]):
                self._text(line.strip())
                continue
            self._tick(float(words[0]))
            if _EVENT.match(b" ".join(words[1:6])):
                continue
            try:
                frame = self._frame(words)
            except (ValueError, IndexError):
                self.left_out[UNREAD] += 1
                continue
            if frame is not None:
                channel, identifier, data = frame
                made.time.append(self._now)
                made.bus.append(bus_number(self.buses, channel))
                made.identifier.append(identifier)
                made.payload.append(data)
        return made

    def _text(self, line: bytes) -> None:
        """A line without a time stamp: header, comment or trigger."""
        if found := _BASE.match(line):
            self._base = 10 if found[1].lower() == b"dec" else 16
            self._relative = (found[2] or b"").lower() == b"relative"
        elif not _TEXT.match(line):
            self.left_out[UNREAD] += 1
        elif (dated := _DATE.match(line)) and (moment := calendar(dated[1].decode("latin-1"))) is not None:
            if self._events:
                self._trigger = moment
            else:
                # The date of the trigger, which follows that of the file, is the one from which the stamps count.
                self.begin = moment

    def _tick(self, stamp: float) -> None:
        """Set the time of the next event [s] from its stamp: in relative logs it counts from the event before."""
        restarted = stamp <= 0.0 if self._relative else stamp + self._offset < self._now
        if self._trigger is not None and self.begin is not None and restarted:
            self._offset = self._trigger - self.begin
            self._now = self._offset + stamp
        elif self._relative:
            self._now += stamp
        else:
            self._now = self._offset + stamp
        self._trigger, self._events = None, self._events + 1

    def _frame(self, words: list[bytes]) -> tuple[str, int, bytes] | None:
        """(channel, identifier, data) of a frame; None for a remote frame, or an identifier that cannot be."""
        if words[1].upper() == b"CANFD":
            channel, direction, name = words[2:5]
            # A name from a database may stand before the bits for the bit rate and the error state.
            rest = words[5:] if words[5].isdigit() else words[6:]
            size, data = int(rest[3]), rest[4:]
            remote = size == 0
        else:
            channel, name, direction, kind = words[1:5]
            remote = kind.lower() == b"r"
            if not remote and kind.lower() != b"d":
                raise ValueError
            size = 0 if remote else min(_SIZES[min(int(words[5], self._base), 15)], 8)
            data = words[6:]
        if direction.lower() not in (b"rx", b"tx", b"txrq") or not 0 <= size <= 64:
            raise ValueError
        number, wide = int(channel) - 1, name[-1:].lower() == b"x"
        identifier = int(name[:-1] if wide else name, self._base)
        if not 0 <= identifier < IDENTIFIERS:
            self.left_out[WIDE] += 1
            return None
        if remote:
            return None
        if len(data) < size:
            raise ValueError
        payload = bytes(int(byte, self._base) for byte in data[:size])
        return str(number), identifier | (EXTENDED if wide else 0), payload


def calendar(text: str) -> float | None:
    """Seconds since 1970 of a date such as "Sep 30 03:06:13.191 pm 2017"; None where it is written otherwise.

    A date has no zone: it counts as UTC, so that every machine gives the same result.
    """
    found = _WRITTEN.match(text.strip())
    if not found:
        return None
    name, day, hour, minute, second, fraction, half, year = found.groups()
    month = next((at for at, names in enumerate(_MONTHS, 1) if name.lower().startswith(names)), 0)
    # Some tools write "pm" after hours from 0 to 23.
    hours = int(hour) % 12 + 12 * (half.lower() == "pm") if half and int(hour) <= 12 else int(hour)
    try:
        moment = datetime(int(year), month, int(day), hours, int(minute), int(second), tzinfo=UTC)
    except ValueError:
        return None
    return moment.timestamp() + float(f"0{fraction or ''}")


def frames_of(blocks: Iterable[bytes]) -> Iterator[Frames]:
    """The frames of a log, block by block, their time counted from the first; the last has the notes on losses."""
    lines, first = _Lines(), None
    frames: Frames | None = None
    for block in blocks:
        found = lines.block(block.splitlines())
        if found.time:
            first = found.time[0] if first is None else first
            time, origin = np.array(found.time) - first, 0.0 if lines.begin is None else lines.begin + first
            frames = stacked(time, found.identifier, found.bus, found.payload, tuple(lines.buses), origin)
            yield frames
    notes = tuple(f"{what} were left out: {number}" for what, number in lines.left_out.items())
    if frames is None:
        why = f" ({'; '.join(notes)})" if notes else ""
        raise InputError(f"the ASC log holds no frame with data{why}; record it, or export it with numeric identifiers")
    if notes:
        yield only_notes(frames, notes)


_HEAD = re.compile(rb"^\s*(//.*\s+)?(date .*\s+)?base\s+(hex|dec)\b", re.IGNORECASE)

FORMAT = Format(
    "asc",
    "ASC (.asc)",
    (".asc",),
    lambda content, time: Log(
        content.path.name, Remembered(lambda: frames_of(whole_lines(content.blocks(), content.path)))
    ),
    lambda head, ending: _HEAD.match(text_begin(head)) is not None,
    text=True,
)
