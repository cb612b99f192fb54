"""Cells of a text table: its rows in blocks, numbers, dates and decimal commas."""

from __future__ import annotations

import codecs
import contextlib
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tierod.core.arrow import calendar_seconds, floats
from tierod.core.errors import InputError
from tierod.io.readers.clocks import DATES, OF_DAY
from tierod.io.readers.content import Content, whole_lines
from tierod.io.readers.csv_layout import MISSING, SAMPLE, Layout

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class Table:
    """A text table."""

    content: Content  # the bytes of the file
    layout: Layout  # layout of the text
    end: bytes  # bytes that end a line
    size: int  # size of the data as unpacked text [bytes]
    lines: int  # number of lines of data
    quotes: int  # number of quotation marks in the data

    def blocks(self) -> Iterator[bytes]:
        """The lines of data, some megabytes at a time."""
        return whole_lines(_below(_in_utf8(self.content), self.layout.begin), self.content.path, self.quoted, self.end)

    @property
    def quoted(self) -> bool:
        """Whether quotation marks enclose cells; not where their number is odd: an open one would swallow lines."""
        return self.quotes > 0 and self.quotes % 2 == 0


def head_of(content: Content) -> bytes:
    """The beginning of the text, longer than the sample for the layout, in UTF-8."""
    head = b""
    for block in _in_utf8(content):
        head += block
        if len(head) > SAMPLE:
            break
    return head


def counted(content: Content, layout: Layout, end: bytes) -> Table:
    """A table whose text was read once from beginning to end, to count its bytes, lines and quotation marks."""
    size = lines = quotes = 0
    last = b""
    for block in _below(_in_utf8(content), layout.begin):
        size, last = size + len(block), block[-1:]
        lines += block.count(end)
        quotes += block.count(b'"')
    return Table(content, layout, end, size, lines + (last != end), quotes)


def _below(blocks: Iterable[bytes], begin: int) -> Iterator[bytes]:
    for block in blocks:
        if begin < len(block):
            yield block[begin:]
        begin = max(begin - len(block), 0)


def _in_utf8(content: Content) -> Iterator[bytes]:
    """The text as stored, or converted to UTF-8 where it is in UTF-16."""
    decoder: Any = None
    for place, block in enumerate(content.blocks()):
        if place == 0 and block[:2] in (b"\xff\xfe", b"\xfe\xff"):
            decoder = codecs.getincrementaldecoder("utf-16")(errors="replace")
        yield block if decoder is None else decoder.decode(block).encode()
    if decoder is not None:
        yield decoder.decode(b"", final=True).encode()


_ISO = re.compile(r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?\s*(Z|[+-]\d\d:?\d\d)?\s*$")
_FRACTION = re.compile(r"\.\d+")


class Rows(NamedTuple):
    """A block of lines as an Arrow table, and the number of broken lines, with another number of cells."""

    table: Any
    broken: int


def numbers(block: bytes, table: Table, names: Sequence[str]) -> tuple[Rows, dict[str, np.ndarray], dict[str, int]]:
    """Columns of a block of lines.

    Returns:
        rows, columns of numbers as floats by name, and number of cells that are no number by name of the column
    """
    import pyarrow as pa

    plain = [name for name in names if name not in table.layout.dates]
    # Where one cell is no number, Arrow refuses the whole block; then its cells are converted one by one.
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
    """The rows, with the cells as text."""
    import pyarrow as pa

    try:
        return _rows(block, table, names, pa.binary())
    except pa.ArrowInvalid as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"{table.content.path}: the table cannot be read to its end ({reason}); export it again"
        ) from None


def _rows(block: bytes, table: Table, names: Sequence[str], kind: pa.DataType) -> Rows:
    import pyarrow as pa
    import pyarrow.csv as text

    layout = table.layout
    broken: list[int] = []

    def skip(row: text.InvalidRow) -> str:
        broken.append(row.actual_columns)
        return "skip"

    found = text.read_csv(
        pa.BufferReader(_copied(_in_unicode(block))),
        read_options=text.ReadOptions(
            column_names=[column.name for column in layout.columns], block_size=3 * len(block) + 1, use_threads=False
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
    """A column of dates in seconds since 1970, or of times of a day since midnight, (n,); NaN where a cell is missing.

    Args:
        column: Arrow column of texts; dates without a zone are in UTC

    Returns:
        seconds, and the cells that are written as a date that does not exist, such as one of the 13th month
    """
    import pyarrow as pa
    import pyarrow.compute as compute

    recorded = column
    column = compute.replace_substring(compute.utf8_trim_whitespace(column), ",", ".")
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
    time = np.array([np.nan if cell is None else _instant(cell) for cell in cells], dtype=float)
    return time, [recorded[int(place)].as_py() for place in np.flatnonzero(np.isnan(time)) if cells[place] is not None]


def _instant(cell: str) -> float:
    """Seconds since 1970 of a date with a time zone, or in UTC without one; NaN where there is no such date."""
    # `fromisoformat` keeps microseconds only, so that the fraction is added as a number.
    try:
        moment = datetime.fromisoformat(_FRACTION.sub("", cell.strip()))
    except ValueError:
        return math.nan
    fraction = _FRACTION.search(cell)
    whole = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    return whole + (float(f"0{fraction[0]}") if fraction else 0.0)
