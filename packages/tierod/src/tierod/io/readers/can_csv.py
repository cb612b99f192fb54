"""CAN frames in a text table, a row for each: those of SavvyCAN and python-can, and others with like names."""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.clocks import is_time, seconds
from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.frames import EXTENDED, IDENTIFIERS, Frames, Log, Remembered, bus_number, only_notes, stacked
from tierod.io.readers.source import Format

_ID = re.compile(r"(can|msg|message|frame|arbitration)?[ _]?(id|identifier|addr|address)( ?\(?(hex|dec)\)?)?$")
_BYTES = re.compile(r"(data|payload)([ _]?bytes)?( ?\(?hex\)?)?$")
_FIRST_BYTE = re.compile(r"(d|b|data|byte)[ _]?\(?0?[01]\)?$")
_HEX = re.compile(r"(0x)?[0-9a-f]{4,128}$|[0-9a-f]{2}( [0-9a-f]{2})+$|[a-z0-9+/]+={1,2}$", re.IGNORECASE)
_TRUE = ("true", "1", "x", "ext", "extended", "yes")
MICROSECONDS = 1e-6  # Unit of stamps without a point, as loggers write them [s]


@dataclass(frozen=True)
class Layout:
    delimiter: str
    time: int  # places of the cells
    identifier: int
    data: int
    many: bool  # whether every byte has a cell of its own, to the end of the row
    extended: int | None
    bus: int | None
    length: int | None
    coded: bool  # whether the bytes are in base64, as python-can writes them


def layout_of(head: bytes) -> Layout | None:
    """The layout of a table whose first rows are CAN frames; None for any other text."""
    lines = [line for line in head[:4096].decode("utf-8-sig", "replace").splitlines() if line.strip()]
    for delimiter in ",;\t" if len(lines) > 1 else "":
        names = [cell.strip().strip('"').lower() for cell in lines[0].split(delimiter)]
        found = {"time": next((at for at, name in enumerate(names) if is_time(name)), None)}
        for role, pattern in (("identifier", _ID), ("data", _BYTES), ("first", _FIRST_BYTE)):
            found[role] = next((at for at, name in enumerate(names) if pattern.match(name)), None)
        data = found["data"] if found["first"] is None else found["first"]
        if found["time"] is None or found["identifier"] is None or data is None:
            continue
        cells = [cell.strip().strip('"') for cell in lines[1].split(delimiter)]
        many = found["first"] is not None
        if len(cells) <= max(found["time"], found["identifier"], data) or not (many or _HEX.match(cells[data])):
            continue
        place = {name: at for at, name in enumerate(names)}
        extended, bus, length = (
            next((place[name] for name in some if name in place), None)
            for some in (("extended", "ext", "ide"), ("bus", "channel", "can"), ("len", "dlc", "length"))
        )
        coded = "arbitration_id" in names
        return Layout(delimiter, found["time"], found["identifier"], data, many, extended, bus, length, coded)
    return None


def frames_of(blocks: Iterable[bytes], layout: Layout) -> Iterator[Frames]:
    """The frames in blocks of whole lines, their time from the first; the last block has notes on losses."""
    names: dict[str, int] = {}
    origin, lines, good, frames, decimal, counts = None, -1, 0, None, None, True
    for block in blocks:
        text = block.decode("utf-8-sig", "replace")
        rows = [line.split(layout.delimiter) for line in text.splitlines() if line.strip()]
        lines += len(rows)
        decimal = _is_decimal(rows, layout) if decimal is None else decimal
        stamps, identifiers, buses, data = [], [], [], []
        for cells in rows:
            try:
                stamp, payload = float(cells[layout.time]), _payload(cells, layout)
                number = _number(cells, layout, decimal)
            except (ValueError, IndexError, binascii.Error):
                continue
            bus = cells[layout.bus].strip() if layout.bus is not None else "0"
            stamps.append(stamp)
            counts = counts and "." not in cells[layout.time]
            identifiers.append(number)
            buses.append(bus_number(names, bus))
            data.append(payload)
        if not stamps:
            continue
        good += len(stamps)
        time, guess = seconds(np.array(stamps), "", "time")
        time = MICROSECONDS * time if counts and not guess else time
        origin = float(time[0]) if origin is None else origin
        frames = stacked(time - origin, identifiers, buses, data, tuple(names), origin)
        yield frames
    if frames is None:
        raise InputError("the table holds no CAN frame with time, identifier and bytes; export it again")
    if lines > good:
        yield only_notes(frames, (f"{lines - good} of {lines} rows are no CAN frames and were left out",))


def _is_decimal(rows: list[list[str]], layout: Layout) -> bool:
    """Whether identifiers are written with digits from 0 to 9 alone and without zeros in front."""
    texts = [cells[layout.identifier].strip().strip('"') for cells in rows[1:] if len(cells) > layout.identifier]
    return all(text.isdigit() and (text == "0" or text[0] != "0") for text in texts)


def _number(cells: list[str], layout: Layout, decimal: bool) -> int:
    text = cells[layout.identifier].strip().strip('"').lower()
    number = int(text.rstrip("xh"), 10 if decimal else 16)
    if not 0 <= number < IDENTIFIERS:
        raise ValueError
    flag = "" if layout.extended is None else cells[layout.extended].strip().lower()
    extended = flag in _TRUE if flag else number > 0x7FF or text.endswith("x")
    return number | (EXTENDED if extended else 0)


def _payload(cells: list[str], layout: Layout) -> bytes:
    if layout.coded:
        return base64.b64decode(cells[layout.data].strip(), validate=True)
    parts = [each.strip().strip('"') for each in (cells[layout.data :] if layout.many else [cells[layout.data]])]
    text = "".join(part.zfill(2) for part in parts if part) if layout.many else parts[0]
    payload = bytes.fromhex(text.removeprefix("0x"))
    return payload if layout.length is None else payload[: int(cells[layout.length])]


def _log(content: Content, _: object) -> Log:
    layout = layout_of(content.head(1 << 12))
    assert layout is not None, "the format is recognised by its layout"
    return log_of(content.path.name, layout, lambda: whole_lines(content.blocks(), content.path))


def log_of(name: str, layout: Layout, blocks: Callable[[], Iterable[bytes]]) -> Log:
    return Log(name, Remembered(lambda: frames_of(blocks(), layout)))


FORMAT = Format("can-csv", "CAN frames in CSV (.csv)", (), _log, lambda head, _: layout_of(head) is not None, text=True)
