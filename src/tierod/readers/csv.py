"""Text tables (CSV) through pyarrow: any delimiter, decimal comma, vendor headers, units in titles or in a row.

What a cell says depends on that cell alone, so that the result does not depend on the blocks in which the text is read.
"""

from __future__ import annotations

import codecs
import contextlib
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from tierod.arrow import calendar_seconds, floats
from tierod.errors import InputError
from tierod.readers.channel_map import GUESSED, TimeEntry
from tierod.readers.clocks import (
    DATES,
    Clock,
    find_clocks,
    require_plausible_rate,
    seconds,
    unit_of,
    unread_clock,
)
from tierod.readers.content import Content, whole_lines
from tierod.readers.csv_layout import MISSING, SAMPLE, Layout, find_layout
from tierod.readers.source import Column, Lane, Piece, Source
from tierod.recording import Channel

_ISO = re.compile(r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?\s*(Z|[+-]\d\d:?\d\d)?\s*$")
_FRACTION = re.compile(r"\.\d+")


@dataclass(frozen=True)
class Table:
    """A text table.

    Args:
        content: the bytes of the file
        layout: how they are laid out
        end: of a line
        size: bytes of the unpacked text in UTF-8
        lines: of data
        quotes: quotation marks in the data
    """

    content: Content
    layout: Layout
    end: bytes
    size: int
    lines: int
    quotes: int

    def blocks(self) -> Iterator[bytes]:
        """The lines of data, some megabytes at a time."""
        return whole_lines(_below(_in_utf8(self.content), self.layout.begin), self.content.path, self.quoted, self.end)

    @property
    def quoted(self) -> bool:
        """Whether a quotation mark quotes: one that is never closed would swallow the lines up to the next one."""
        return self.quotes > 0 and self.quotes % 2 == 0


def open_csv(content: Content, time: TimeEntry = GUESSED) -> Source:
    """A text table.

    Args:
        content: the bytes of the file
        time: which column is the time, as a user says; not looked at in a file that tierod wrote

    Raises:
        InputError: no table of numbers with a time column is in it
    """
    path = content.path
    head = _head(content)
    try:
        layout = find_layout(head)
    except InputError as error:
        raise InputError(f"{path} {error}") from None
    table = _counted(content, layout, b"\n" if b"\n" in head else b"\r")
    usable = {*layout.numeric, *layout.dates}
    columns = [column for column in layout.columns if column.name in usable]
    time = GUESSED if "layout" in layout.about else time
    if time.column is None:
        _refuse_text_as_clock(path, layout, columns)
    clocks, units = _clocks(path, columns, _beginning(head, table), time)
    members = tuple(
        column
        for column in columns
        if any(column.name in clock.columns for clock in clocks) and column.name in layout.numeric
    )
    if not members:
        raise InputError(f"{path} holds a time column but no other column of numbers; export it with signals")
    broken: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock = {clock: [name for name in names if name in clock.columns] for clock in clocks}
        wanted = {clock: members for clock, members in by_clock.items() if members}
        found = [
            Lines(
                table,
                clock,
                units[clock.column],
                tuple(each),
                padded=len(clocks) > 1,
                broken=broken if place == 0 else None,
            )
            for place, (clock, each) in enumerate(wanted.items())
        ]
        return [each.pieces() for each in found]

    about = layout.about
    metadata = {**about.get("metadata", {}), "format": "CSV"}
    origin = float(about.get("origin", 0.0))
    return Source(members, lanes, metadata, origin, found=lambda: tuple(broken))


def _clocks(
    path: Any, columns: Sequence[Column], head: dict[str, np.ndarray], time: TimeEntry
) -> tuple[tuple[Clock, ...], dict[str, str]]:
    """The clocks, and the unit of each; "" where none is given."""
    increasing = [name for name, part in head.items() if len(part) > 2 and bool((part[1:] > part[:-1]).all())]
    try:
        clocks = find_clocks(columns, increasing, time)
        by_name = {column.name: column for column in columns}
        units = {clock.column: unit_of(by_name[clock.column], time) for clock in clocks}
        # Where one clock is a date, time is beyond doubt.
        if all(name in head for name in units):
            require_plausible_rate((name, unit, head[name]) for name, unit in units.items())
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return clocks, units


def _head(content: Content) -> bytes:
    """The beginning of the text, more than the layout is found from."""
    head = b""
    for block in _in_utf8(content):
        head += block
        if len(head) > SAMPLE:
            break
    return head


def _counted(content: Content, layout: Layout, end: bytes) -> Table:
    size = lines = quotes = 0
    last = b""
    for block in _below(_in_utf8(content), layout.begin):
        size, last = size + len(block), block[-1:]
        lines += block.count(end)
        quotes += block.count(b'"')
    return Table(content, layout, end, size, lines + (last != end), quotes)


def _below(blocks: Iterable[bytes], begin: int) -> Iterator[bytes]:
    """The blocks without the first bytes."""
    for block in blocks:
        if begin < len(block):
            yield block[begin:]
        begin = max(begin - len(block), 0)


def _refuse_text_as_clock(path: Any, layout: Layout, usable: Sequence[Column]) -> None:
    clock = unread_clock([column for column in layout.columns if column.name in layout.texts], usable)
    if clock is not None:
        raise InputError(
            f"{path}: the time column '{clock.name}' is written as '{layout.texts[clock.name].strip()[:40]}'; "
            f"give it in seconds, or as a date that reads {DATES}"
        )


def _in_utf8(content: Content) -> Iterator[bytes]:
    """The text as it is, or in UTF-8 where it is in UTF-16."""
    decoder: Any = None
    for place, block in enumerate(content.blocks()):
        if place == 0 and block[:2] in (b"\xff\xfe", b"\xfe\xff"):
            decoder = codecs.getincrementaldecoder("utf-16")(errors="replace")
        yield block if decoder is None else decoder.decode(block).encode()
    if decoder is not None:
        yield decoder.decode(b"", final=True).encode()


@dataclass
class Lines:
    """The columns with one clock, block by block.

    Args:
        table: of the file
        clock: that times them
        unit: of the clock; "" where none is given
        names: of the columns
        padded: whether rows without a stamp only fill the table up, beside longer columns
        broken: takes the note on broken lines
    """

    table: Table
    clock: Clock
    unit: str
    names: tuple[str, ...]
    padded: bool
    broken: list[str] | None
    bad: dict[str, int] = field(default_factory=dict)

    def pieces(self) -> Lane:
        """The channels, from the first line to the last."""
        layout = self.table.layout
        columns = {column.name: column for column in layout.columns}
        about = {each["name"]: each for each in layout.about.get("channels", {}).values()}
        guess, lost, done = "", 0, 0
        for block in self.table.blocks():
            rows, values = self._read(block)
            lost, done = lost + rows.broken, done + len(block)
            if lost and self.broken is not None:
                self.broken[:] = [f"{lost} of {self.table.lines} lines are broken and were left out"]
            if self.clock.column in layout.dates:
                time = _calendar(rows.table[self.clock.column], self.clock.column)
            else:
                time, found = seconds(values[self.clock.column], self.unit, self.clock.column)
                guess = guess or found
            kept = np.isfinite(time) if self.padded else np.ones(len(time), dtype=bool)
            time = time if kept.all() else time[kept]
            made = []
            for name in self.names:
                entry = about.get(name, {})
                column = values[name] if kept.all() else values[name][kept]
                channel = Channel(
                    name, time, column, columns[name].unit, entry.get("source", name), entry.get("note", "")
                )
                bad = f"{self.bad[name]} cells are no numbers" if self.bad.get(name) else ""
                made.append(channel.noted(guess, bad))
            yield Piece(made, done / self.table.size)

    def _read(self, block: bytes) -> tuple[Rows, dict[str, np.ndarray]]:
        """The rows of a block, and its columns of numbers as floats."""
        names = list(dict.fromkeys([self.clock.column, *self.names]))
        rows, values, bad = _numbers(block, self.table, names)
        for name, count in bad.items():
            self.bad[name] = self.bad.get(name, 0) + count
        return rows, values


class Rows(NamedTuple):
    """A block of lines as a table of Arrow, and how many of them have another number of cells than the table."""

    table: Any
    broken: int


def _numbers(block: bytes, table: Table, names: Sequence[str]) -> tuple[Rows, dict[str, np.ndarray], dict[str, int]]:
    """(rows, columns of numbers as floats, cells per column that are no number)."""
    import pyarrow as pa

    plain = [name for name in names if name not in table.layout.dates]
    try:
        rows = _rows(block, table, names, pa.float64())
        return rows, {name: floats(rows.table[name]) for name in plain}, {}
    except pa.ArrowInvalid:
        rows = _as_text(block, table, names)
    columns, bad = {}, {}
    for name in plain:
        columns[name], bad[name] = _tolerant(rows.table[name], table.layout.decimal)
    return rows, columns, bad


def _as_text(block: bytes, table: Table, names: Sequence[str]) -> Rows:
    """The rows with the cells as they are written."""
    import pyarrow as pa

    try:
        return _rows(block, table, names, pa.binary())
    except pa.ArrowInvalid as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"{table.content.path}: the table cannot be read to its end ({reason}); export it again"
        ) from None


def _rows(block: bytes, table: Table, names: Sequence[str], kind: Any) -> Rows:
    import pyarrow as pa
    import pyarrow.csv as text

    layout = table.layout
    broken: list[int] = []

    def skip(row: Any) -> str:
        broken.append(row.actual_columns)
        return "skip"

    found = text.read_csv(
        pa.BufferReader(_in_unicode(block)),
        read_options=text.ReadOptions(
            column_names=[column.name for column in layout.columns], block_size=3 * len(block) + 1
        ),
        parse_options=text.ParseOptions(
            delimiter=layout.delimiter,
            quote_char='"' if table.quoted else False,
            newlines_in_values=table.quoted,
            invalid_row_handler=skip,
        ),
        convert_options=text.ConvertOptions(
            column_types={name: pa.string() if name in layout.dates else kind for name in names},
            include_columns=list(names),
            decimal_point=layout.decimal,
            null_values=[*MISSING, *(f" {word}" for word in MISSING if word)],
            strings_can_be_null=True,
        ),
    )
    return Rows(found, len(broken))


def _in_unicode(block: bytes) -> bytes:
    """The block with marks where it is in no Unicode: the library decodes the lines that are broken."""
    if not block.isascii():
        try:
            block.decode()
        except UnicodeDecodeError:
            return block.decode(errors="replace").encode()
    return block


def _tolerant(column: Any, decimal: str) -> tuple[np.ndarray, int]:
    """Cells as floats, each by itself, and how many of them are no number."""
    import pyarrow as pa
    import pyarrow.compute as compute

    try:
        text = column.cast(pa.string())
        return floats((compute.replace_substring(text, ",", ".") if decimal == "," else text).cast(pa.float64())), 0
    except pa.ArrowInvalid:
        return _cell_by_cell(column.to_pylist(), decimal)


def _cell_by_cell(cells: list[bytes | None], decimal: str) -> tuple[np.ndarray, int]:
    values, bad = np.full(len(cells), np.nan), 0
    for place, cell in enumerate(cells):
        if cell is not None and cell.strip():
            try:
                values[place] = float(cell.replace(b",", b".") if decimal == "," else cell)
            except ValueError:
                bad += 1
    return values, bad


def _calendar(column: Any, name: str) -> np.ndarray:
    """A column of dates in seconds since 1970."""
    import pyarrow as pa

    for zone in (None, "UTC"):
        with contextlib.suppress(pa.ArrowException):
            return calendar_seconds(column.cast(pa.timestamp("ns", zone)))
    cells = column.to_pylist()
    odd = next((cell for cell in cells if cell is not None and not _ISO.match(cell)), None)
    if odd is not None:
        raise InputError(
            f"the time column '{name}' holds '{odd[:40]}' where dates read {DATES}: correct it, or give seconds"
        )
    return np.array([np.nan if cell is None else _instant(cell) for cell in cells], dtype=float)


def _instant(cell: str) -> float:
    """Seconds since 1970 of a date with a time zone, or of one in UTC."""
    moment = datetime.fromisoformat(_FRACTION.sub("", cell.strip()))
    fraction = _FRACTION.search(cell)
    whole = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    return whole + (float(f"0{fraction[0]}") if fraction else 0.0)


def _beginning(head: bytes, table: Table) -> dict[str, np.ndarray]:
    """The beginning of the columns of numbers."""
    part = head[: table.layout.begin + (1 << 16)]
    part = part[: part.rfind(table.end) + 1] if len(part) < len(head) else part
    part = part[table.layout.begin :]
    return _numbers(part, table, table.layout.numeric)[1] if part else {}
