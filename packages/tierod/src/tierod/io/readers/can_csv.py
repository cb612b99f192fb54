"""CAN frames in a text table, a row for each: those of SavvyCAN and python-can, and others with like names."""

from __future__ import annotations

import base64
import binascii
import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError
from tierod.io.readers.clocks import is_time, seconds
from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.csv import instant
from tierod.io.readers.frames import EXTENDED, IDENTIFIERS, Frames, Log, Remembered, bus_number, only_notes, stacked
from tierod.io.readers.source import Format

_ID = re.compile(r"(can|msg|message|frame|arbitration)?[ _]?(id|identifier|addr|address)( ?\(?(hex|dec)\)?)?$")
_BYTES = re.compile(r"(data|payload)([ _]?byte(s|\(s\)))?( ?\(?hex\)?)?$")
_BYTE = re.compile(r"(?:d|b|data|byte)[ _]?[(\[]?0?(\d\d?)[)\]]?$")
_CELL = re.compile(r"(0x)?[0-9a-f]{0,2}$|1\d\d$|2[0-4]\d$|25[0-5]$", re.IGNORECASE)
_HEX = re.compile(r"(0x)?[0-9a-f]{4,128}$|[0-9a-f]{2}( [0-9a-f]{2})+$|[a-z0-9+/]+={1,2}$", re.IGNORECASE)
# In bytes or identifiers: no decimal number of a usual table
_NO_NUMBER = re.compile(r"[a-f x+/=]|^0\d|^\d{16}", re.IGNORECASE)
_FEWEST = 4  # Cells with a byte each, from which a table without lengths holds frames
_TRUE = ("true", "1", "x", "ext", "extended", "yes")
MICROSECONDS = 1e-6  # Unit of stamps without a point, as loggers write them [s]


@dataclass(frozen=True)
class Layout:
    delimiter: str
    time: int  # places of the cells
    identifier: int
    data: int
    many: int  # number of cells with one byte each; 0 where all are in one cell
    extended: int | None
    bus: int | None
    length: int | None
    coded: bool  # whether the bytes are in base64, as python-can writes them


def layout_of(head: bytes) -> Layout | None:
    """The layout of a table whose first rows are CAN frames; None for any other text."""
    lines = [line for line in head[:4096].decode("utf-8-sig", "replace").splitlines() if line.strip()]
    for delimiter in ",;\t" if len(lines) > 1 else "":
        names = [cell.strip().strip('"').lower() for cell in lines[0].split(delimiter)]
        place = {name: at for at, name in reversed(list(enumerate(names)))}
        time, identifier, data = (
            next((at for at, name in enumerate(names) if test(name)), None)
            for test in (lambda name: is_time(name) or name.startswith("timestamp"), _ID.match, _BYTES.match)
        )
        bytewise = [at for at, name in enumerate(names) if (found := _BYTE.match(name)) and int(found[1]) < 64]
        data = bytewise[0] if len(bytewise) > 1 else data
        if time is None or identifier is None or data is None:
            continue
        extended, bus, length = (
            next((place[name] for name in some if name in place), None)
            for some in (
                ("extended", "ext", "ide"),
                ("bus", "channel", "can", "buschannel"),
                ("datalength", "len", "dlc", "length"),
            )
        )
        many = len(bytewise) if len(bytewise) > 1 else 0
        rows = [line.split(delimiter) for line in lines[1:21]][: max(len(lines) - 2, 1)]
        coded = "arbitration_id" in names and not _is_hex(rows[0], data, length)
        layout = Layout(delimiter, time, identifier, data, many, extended, bus, length, coded)
        if _holds_frames(rows, layout):
            return layout
    return None


def _is_hex(row: list[str], data: int, length: int | None) -> bool:
    """Whether the bytes are written in hexadecimal digits, not in base64, of which each row alone would be valid."""
    if len(row) <= max(data, length or 0):
        return False
    text = row[data].strip().strip('"')
    stated = length is not None and row[length].strip() == str(len(text) // 2)
    return " " in text or text.startswith("0x") or (stated and len(text) % 2 == 0)


def _holds_frames(rows: list[list[str]], layout: Layout) -> bool:
    """Whether the rows hold bytes, which columns of the same names in another table do not."""
    rows = [row for row in rows if len(row) > max(layout.time, layout.identifier, layout.data)]
    some = [[cell.strip().strip('"') for cell in row[layout.data : layout.data + max(layout.many, 1)]] for row in rows]
    if layout.many:
        return (
            bool(some)
            and all(_CELL.match(cell) for row in some for cell in row[:1])
            and (layout.length is not None or layout.many >= _FEWEST)
        )
    if not some or not all(_HEX.match(row[0]) or not row[0] for row in some):
        return False
    told = [*(row[0] for row in some), *(row[layout.identifier] for row in rows)]
    return layout.length is not None or any(_NO_NUMBER.search(text.strip()) for text in told)


def frames_of(blocks: Iterable[bytes], layout: Layout) -> Iterator[Frames]:
    """The frames in blocks of whole lines, their time from the first; the last block has notes on losses."""
    names: dict[str, int] = {}
    origin, lines, good, frames, decimal, counts, base = None, -1, 0, None, None, True, 16
    for block in blocks:
        text = block.decode("utf-8-sig", "replace")
        rows = [line.split(layout.delimiter) for line in text.splitlines() if line.strip()]
        lines += len(rows)
        if decimal is None:
            decimal = _is_decimal(rows, slice(layout.identifier, layout.identifier + 1))
            bytewise = slice(layout.data, layout.data + layout.many)
            base = 10 if layout.many and _is_decimal(rows, bytewise) else 16
        stamps, identifiers, buses, data = [], [], [], []
        for cells in rows:
            try:
                stamp, payload = _stamp(cells[layout.time]), _payload(cells, layout, base)
                number = _number(cells, layout, decimal)
                bus = cells[layout.bus].strip() if layout.bus is not None else "0"
            except (ValueError, IndexError, binascii.Error):
                continue
            stamps.append(stamp)
            counts = counts and cells[layout.time].strip().isdigit()
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


def _is_decimal(rows: list[list[str]], cells: slice) -> bool:
    """Whether cells are written with digits from 0 to 9 alone and without zeros in front."""
    texts = [cell.strip().strip('"') for row in rows[1:] for cell in row[cells]]
    return all(not text or (text.isdigit() and (text == "0" or text[0] != "0")) for text in texts)


def _stamp(cell: str) -> float:
    """Time in seconds, or as it is counted; of a date since 1970."""
    text = cell.strip().strip('"')
    if ":" not in text:
        return float(text)
    stamp = instant(text if "-" in text else f"1970-01-01 {text}")
    if math.isnan(stamp):
        raise ValueError
    return stamp


def _number(cells: list[str], layout: Layout, decimal: bool) -> int:
    text = cells[layout.identifier].strip().strip('"').lower()
    number = int(text.rstrip("xh"), 10 if decimal else 16)
    if not 0 <= number < IDENTIFIERS:
        raise ValueError
    flag = "" if layout.extended is None else cells[layout.extended].strip().lower()
    extended = flag in _TRUE if flag else number > 0x7FF or text.endswith("x")
    return number | (EXTENDED if extended else 0)


def _payload(cells: list[str], layout: Layout, base: int) -> bytes:
    if layout.coded:
        return base64.b64decode(cells[layout.data].strip(), validate=True)
    length = None if layout.length is None else int(cells[layout.length])
    if layout.many:
        parts = [each.strip().strip('"') for each in cells[layout.data : layout.data + layout.many]][:length]
        return bytes(int(part, base) for part in parts if part)
    return bytes.fromhex(cells[layout.data].strip().strip('"').removeprefix("0x"))[:length]


def _log(content: Content, _: object) -> Log:
    layout = layout_of(content.head(1 << 12))
    assert layout is not None, "the format is recognised by its layout"
    return log_of(content.path.name, layout, lambda: whole_lines(content.blocks(), content.path))


def log_of(name: str, layout: Layout, blocks: Callable[[], Iterable[bytes]]) -> Log:
    return Log(name, Remembered(lambda: frames_of(blocks(), layout)))


FORMAT = Format("can-csv", "CAN frames in CSV (.csv)", (), _log, lambda head, _: layout_of(head) is not None, text=True)
