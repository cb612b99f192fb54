"""Text tables (CSV): any delimiter, decimal comma, vendor headers, units in titles or in a row."""

from __future__ import annotations

import codecs
import contextlib
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.frames import calendar_seconds, floats
from tierod.core.recording import Channel
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import (
    DATES,
    DAY,
    OF_DAY,
    PACKED,
    Clock,
    OwnRates,
    find_clocks,
    is_packed,
    past_midnight,
    period_of,
    require_plausible_rate,
    seconds,
    unit_of,
    unread_clock,
)
from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.csv_layout import MISSING, SAMPLE, SPACES, find_layout
from tierod.io.readers.source import Column, Format, Lane, Piece, Source

if TYPE_CHECKING:
    import pyarrow as pa

_ISO = re.compile(r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?\s*(Z|[+-]\d\d:?\d\d)?\s*$")
_MONTHS = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec"
_FRACTION = re.compile(r"\.\d+")
_BETWEEN, _AROUND = re.compile(rb"[ \t]+"), re.compile(rb"^[ \t]+|[ \t]+(?=\r?$)", re.MULTILINE)


class Rows(NamedTuple):
    table: Any  # Arrow table: dates as texts
    columns: dict[str, np.ndarray]  # of numbers
    bad: dict[str, int]  # number of cells that are no number, by column
    broken: int  # lines with another number of cells, which are left out


class Table:
    """A text table; it is read once from beginning to end, to count its bytes, lines and quotation marks."""

    def __init__(self, content: Content):
        self.content, self.head = content, b""
        for block in _in_utf8(content):
            self.head += block
            if len(self.head) > SAMPLE:
                break
        try:
            self.layout = find_layout(self.head)
        except InputError as error:
            raise InputError(f"{content.path} {error}") from None
        self.end = b"\n" if b"\n" in self.head else b"\r"
        self.size = self.lines = quotes = 0
        last = b""
        for block in self._below():
            self.size, last = self.size + len(block), block[-1:]
            self.lines += block.count(self.end)
            quotes += block.count(b'"')
        self.lines += last != self.end
        # Where the number of quotation marks is odd they enclose no cells: an open one would swallow lines.
        self.quoted = quotes > 0 and quotes % 2 == 0

    def _below(self) -> Iterator[bytes]:
        """The text below the rows of titles."""
        begin = self.layout.begin
        for block in _in_utf8(self.content):
            if begin < len(block):
                yield block[begin:]
            begin = max(begin - len(block), 0)

    def blocks(self) -> Iterator[bytes]:
        """The lines of data, some megabytes at a time."""
        return whole_lines(self._below(), self.content.path, self.quoted, self.end)

    def beginning(self) -> dict[str, np.ndarray]:
        part = self.head[: self.layout.begin + (1 << 16)]
        part = part[: part.rfind(self.end) + 1] if len(part) < len(self.head) else part
        part = part[self.layout.begin :]
        return self.rows(part, self.layout.numeric).columns if part else {}

    def rows(self, block: bytes, names: Sequence[str]) -> Rows:
        import pyarrow as pa

        plain = [name for name in names if name not in self.layout.dates]
        # Where one cell is no number, Arrow refuses the whole block; then its cells are converted one by one.
        try:
            table, broken = self._read(block, names, pa.float64())
            return Rows(table, {name: floats(table[name]) for name in plain}, {}, broken)
        except pa.ArrowInvalid:
            pass
        try:
            table, broken = self._read(block, names, pa.binary())
        except pa.ArrowInvalid as error:
            reason = " ".join(str(error).split())[:120]
            raise InputError(
                f"{self.content.path}: the table cannot be read to its end ({reason}); export it again"
            ) from None
        found = {name: _tolerant(table[name], self.layout.decimal) for name in plain}
        return Rows(
            table, {n: values for n, (values, _) in found.items()}, {n: bad for n, (_, bad) in found.items()}, broken
        )

    def _read(self, block: bytes, names: Sequence[str], kind: pa.DataType) -> tuple[Any, int]:
        import pyarrow as pa
        import pyarrow.csv as text

        layout = self.layout
        broken: list[int] = []

        def skip(row: text.InvalidRow) -> str:
            broken.append(row.actual_columns)
            return "skip"

        if layout.delimiter == SPACES:
            block = _BETWEEN.sub(b" ", _AROUND.sub(b"", block))
        found = text.read_csv(
            pa.BufferReader(_copied(_in_unicode(block))),
            read_options=text.ReadOptions(
                column_names=[column.name for column in layout.columns],
                block_size=3 * len(block) + 1,
                use_threads=False,
            ),
            parse_options=text.ParseOptions(
                delimiter=layout.delimiter,
                quote_char='"' if self.quoted else False,
                newlines_in_values=self.quoted,
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
        return found, len(broken)


def open_csv(content: Content, time: TimeEntry = GUESSED) -> Source:
    """A text table; the time column that a user gives is ignored in a file that tierod wrote."""
    path, table = content.path, Table(content)
    layout = table.layout
    columns = [column for column in layout.columns if column.name in {*layout.numeric, *layout.dates}]
    time = GUESSED if "layout" in layout.about else time
    texts = [column for column in layout.columns if column.name in layout.texts]
    if time.column is None and (clock := unread_clock(texts, columns)) is not None:
        raise InputError(
            f"{path}: the time column '{clock.name}' is written as '{layout.texts[clock.name].strip()[:40]}'; "
            f"give it in seconds, as a date that reads {DATES}, or as a time of day {OF_DAY}"
        )
    head = table.beginning()
    clocks, units = _clocks(path, columns, head, time)
    for name in units:
        if not units[name] and name in head:
            # The beginning, which is read already, decides for any clock that counts from its start.
            parts = (table.rows(block, [name]).columns[name] for block in table.blocks())
            units[name] = PACKED if is_packed(chain([head[name]], parts)) else ""
    timed = {name for clock in clocks for name in clock.columns}
    members = tuple(column for column in columns if column.name in timed and column.name in layout.numeric)
    if not members:
        raise InputError(f"{path} holds a time column but no other column of numbers; export it with signals")
    broken: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock = {clock: [name for name in names if name in clock.columns] for clock in clocks}
        wanted = [(clock.column, members) for clock, members in by_clock.items() if members]
        return [
            _lane(table, clock, units[clock], members, len(clocks) > 1, broken if place == 0 else [])
            for place, (clock, members) in enumerate(wanted)
        ]

    metadata = {**layout.about.get("metadata", {}), "format": "CSV"}
    origin = float(layout.about.get("origin", 0.0))
    return Source(members, lanes, metadata, origin, found=lambda: tuple(broken), texts=tuple(layout.texts))


def _clocks(
    path: Path, columns: Sequence[Column], head: dict[str, np.ndarray], time: TimeEntry
) -> tuple[tuple[Clock, ...], dict[str, str]]:
    """The clocks, and the unit of each, which is "" where none is given."""
    increasing = [name for name, part in head.items() if len(part) > 2 and bool((part[1:] > part[:-1]).all())]
    try:
        clocks = find_clocks(columns, increasing, time)
        by_name = {column.name: column for column in columns}
        units = {clock.column: unit_of(by_name[clock.column], time) for clock in clocks}
        # Only where all clocks are numbers: a date leaves no doubt about the time.
        if all(name in head for name in units):
            require_plausible_rate((name, unit, head[name]) for name, unit in units.items())
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return clocks, units


def _lane(table: Table, clock: str, unit: str, names: Sequence[str], padded: bool, said: list[str]) -> Lane:
    """The columns with one clock, block by block."""
    layout = table.layout
    columns = {column.name: column for column in layout.columns}
    about = {each["name"]: each for each in layout.about.get("channels", {}).values()}
    bad: Counter[str] = Counter()
    guess, lost, done, last, stamps = "", 0, 0, np.nan, ""
    odd: list[str] = []
    own_rates = OwnRates()
    for block in table.blocks():
        rows = table.rows(block, list(dict.fromkeys([clock, *names])))
        bad.update(rows.bad)
        lost, done = lost + rows.broken, done + len(block)
        if lost:
            said[:] = [f"{lost} of {table.lines} lines are broken and were left out"]
        if clock in layout.dates:
            time, wrong = calendar(rows.table[clock], clock)
            odd += wrong
            stamps = f"{len(odd)} time stamps do not exist, such as '{odd[0].strip()[:40]}'" if odd else ""
        else:
            time, found = seconds(rows.columns[clock], unit, clock)
            guess = guess or found
            stamps = f"{bad[clock]} time stamps are not numbers" if bad[clock] else ""
        if clock in layout.dates or unit == PACKED or period_of(clock) > DAY:
            time = past_midnight(time, last, period_of(clock))
            last = time[there[-1]] if len(there := np.flatnonzero(np.isfinite(time))) else last
        kept = np.isfinite(time) if padded else np.ones(len(time), dtype=bool)
        time = time if kept.all() else time[kept]
        made = []
        for name in names:
            entry, values = about.get(name, {}), rows.columns[name]
            values = values if kept.all() else values[kept]
            channel = Channel(name, time, values, columns[name].unit, entry.get("source", name), entry.get("note", ""))
            made.append(channel.noted(guess, f"{bad[name]} cells are not numbers" if bad[name] else "", stamps))
        yield Piece(made if "layout" in layout.about else own_rates(made), done / table.size)


def _in_utf8(content: Content) -> Iterator[bytes]:
    """The text as stored, or converted to UTF-8 where it is in UTF-16."""
    decoder: Any = None
    for place, block in enumerate(content.blocks()):
        if place == 0 and block[:2] in (b"\xff\xfe", b"\xfe\xff"):
            decoder = codecs.getincrementaldecoder("utf-16")(errors="replace")
        yield block if decoder is None else decoder.decode(block).encode()
    if decoder is not None:
        yield decoder.decode(b"", final=True).encode()


def _copied(block: bytes) -> pa.Buffer:
    """The block in memory of Arrow: a library thread that freed memory of Python at exit would abort the process.

    For the same reason `skip` is called on this thread alone.
    """
    import pyarrow as pa

    memory = pa.allocate_buffer(len(block))
    with pa.FixedSizeBufferWriter(memory) as writer:
        writer.write(block)
    return memory


def _in_unicode(block: bytes) -> bytes:
    """The block with replacement characters where it is not UTF-8, since the library decodes broken lines."""
    if not block.isascii():
        try:
            block.decode()
        except UnicodeDecodeError:
            return block.decode(errors="replace").encode()
    return block


def _tolerant(column: pa.ChunkedArray, decimal: str) -> tuple[np.ndarray, int]:
    """Cells as floats, each by itself, and the number of cells that are no number."""
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


def calendar(column: pa.ChunkedArray, name: str) -> tuple[np.ndarray, list[str]]:
    """A column of dates, in UTC without a zone, in seconds since 1970, or of times of a day since midnight, (n,).

    Returns:
        seconds, NaN where a cell is missing, and the cells that are written as a date that does not exist
    """
    import pyarrow as pa
    import pyarrow.compute as compute

    recorded = column
    column = compute.replace_substring(compute.utf8_trim_whitespace(column), ",", ".")
    column = compute.replace_substring_regex(column, r"^(\d\d)\.(\d\d)\.(\d{4})", r"\3-\2-\1")
    if any(cell is not None and cell[3:4].isalpha() for cell in column.slice(0, 1).to_pylist()):
        for number, month in enumerate(_MONTHS.split(), 1):
            column = compute.replace_substring_regex(column, rf"^(\d\d)-{month}-(\d{{4}})", rf"\2-{number:02d}-\1")
    # A time of day without a date counts from midnight of day zero.
    column = compute.replace_substring_regex(column, r"^(\d\d:)", r"1970-01-01 \1")
    for zone in (None, "UTC"):
        with contextlib.suppress(pa.ArrowException):
            return calendar_seconds(column.cast(pa.timestamp("ns", zone))), []
    cells = column.to_pylist()
    odd = next((cell for cell in cells if cell is not None and not _ISO.match(cell)), None)
    if odd is not None:
        raise InputError(
            f"the time column '{name}' holds '{odd[:40]}' where dates read {DATES}, and times of a day {OF_DAY}: "
            "correct it, or give seconds"
        )
    time = np.array([np.nan if cell is None else instant(cell) for cell in cells], dtype=float)
    return time, [recorded[int(place)].as_py() for place in np.flatnonzero(np.isnan(time)) if cells[place] is not None]


def instant(cell: str) -> float:
    """Seconds since 1970 of a date; NaN where there is no such date."""
    # `fromisoformat` keeps microseconds only, so that the fraction is added as a number.
    try:
        moment = datetime.fromisoformat(_FRACTION.sub("", cell.strip()))
    except ValueError:
        return math.nan
    fraction = _FRACTION.search(cell)
    whole = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    return whole + (float(f"0{fraction[0]}") if fraction else 0.0)


# It recognises no beginning: any text that is of no other format is read as a text table.
_ENDINGS = (".csv", ".txt", ".tsv", ".vbo")
FORMAT = Format("csv", f"CSV ({', '.join(_ENDINGS)})", _ENDINGS, open_csv, lambda *_: False, text=True)
