"""Text tables (CSV) through pyarrow: any delimiter, decimal comma, vendor headers, units in titles or in a row."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tierod.arrow import calendar_seconds, floats, is_number
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
from tierod.readers.csv_layout import MISSING, Layout, find_layout
from tierod.readers.source import Column, Source
from tierod.recording import Channel

_ISO = re.compile(r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d{1,9})?)?\s*(Z|[+-]\d\d:?\d\d)?\s*$|None$")


def open_csv(path: Path, data: bytes, time: TimeEntry = GUESSED) -> Source:
    """A text table.

    Args:
        path: for messages
        data: the whole file
        time: which column is the time, as a user says; not looked at in a file that tierod wrote

    Raises:
        InputError: no table of numbers with a time column is in it
    """
    data = _in_utf8(data)
    try:
        layout = find_layout(data)
    except InputError as error:
        raise InputError(f"{path} {error}") from None
    usable = {*layout.numeric, *layout.dates}
    columns = [column for column in layout.columns if column.name in usable]
    time = GUESSED if "layout" in layout.about else time
    if time.column is None:
        _refuse_text_as_clock(path, layout, columns)
    head = _head(data, layout)
    clocks, units = _clocks(path, columns, head, time)
    members = tuple(
        column
        for column in columns
        if any(column.name in clock.columns for clock in clocks) and column.name in layout.numeric
    )
    if not members:
        raise InputError(f"{path} holds a time column but no other column of numbers; export it with signals")
    broken = _count_broken(data, layout)

    def load(names: Sequence[str]) -> list[Channel]:
        return _channels(data, layout, clocks, units, {column.name: column for column in columns}, names)

    about = layout.about
    metadata = {**about.get("metadata", {}), "format": "CSV"}
    return Source(members, load, metadata, float(about.get("origin", 0.0)), tuple(filter(None, [broken])))


def _clocks(
    path: Path, columns: Sequence[Column], head: dict[str, np.ndarray], time: TimeEntry
) -> tuple[tuple[Clock, ...], dict[str, str]]:
    """The clocks, and the unit of each as far as one is told."""
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


def _refuse_text_as_clock(path: Path, layout: Layout, usable: Sequence[Column]) -> None:
    clock = unread_clock([column for column in layout.columns if column.name in layout.texts], usable)
    if clock is not None:
        raise InputError(
            f"{path}: the time column '{clock.name}' is written as '{layout.texts[clock.name].strip()[:40]}'; "
            f"give it in seconds, or as a date that reads {DATES}"
        )


def _in_utf8(data: bytes) -> bytes:
    """The text in UTF-8; what is in no Unicode is taken as Latin-1, in which every byte is a letter."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace").encode()
    if data.isascii():
        return data
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


def _table(data: bytes, layout: Layout, names: Sequence[str], kind: Any, broken: list[int]) -> Any:
    import pyarrow as pa
    import pyarrow.csv as text

    def skip(row: Any) -> str:
        broken.append(row.actual_columns)
        return "skip"

    quotes = data.count(b'"', layout.begin)
    kinds = {name: kind for name in names if kind is not None and name not in layout.dates}
    return text.read_csv(
        pa.BufferReader(pa.py_buffer(data).slice(layout.begin)),
        read_options=text.ReadOptions(column_names=[column.name for column in layout.columns], block_size=1 << 22),
        parse_options=text.ParseOptions(
            delimiter=layout.delimiter,
            # A quotation mark that is never closed would swallow the lines up to the next one.
            quote_char=False if quotes % 2 else '"',
            newlines_in_values=quotes > 0,
            invalid_row_handler=skip,
        ),
        convert_options=text.ConvertOptions(
            column_types=kinds,
            include_columns=list(names),
            decimal_point=layout.decimal,
            null_values=[*MISSING, *(f" {word}" for word in MISSING if word)],
            strings_can_be_null=True,
        ),
    )


def _read(data: bytes, layout: Layout, names: Sequence[str]) -> tuple[Any, dict[str, np.ndarray], dict[str, int]]:
    """(table, columns as floats, cells per column that are no number)."""
    import pyarrow as pa

    try:
        table = _table(data, layout, names, pa.float64(), [])
        return table, {name: floats(table[name]) for name in names if name not in layout.dates}, {}
    except pa.ArrowInvalid:
        table = _as_found(data, layout, names, [])
    columns, bad = {}, {}
    for name in names:
        if name not in layout.dates:
            columns[name], bad[name] = _numbers(table[name], layout.decimal)
    return table, columns, bad


def _as_found(data: bytes, layout: Layout, names: Sequence[str], broken: list[int]) -> Any:
    """The table with columns of whatever they hold."""
    import pyarrow as pa

    try:
        return _table(data, layout, names, None, broken)
    except pa.ArrowInvalid as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"the table cannot be read to its end ({reason}); export it again") from None


def _numbers(column: Any, decimal: str) -> tuple[np.ndarray, int]:
    """A column as floats, and how many of its cells are no number: only one that has such is text."""
    import pyarrow as pa

    if is_number(column.type) or pa.types.is_null(column.type):
        return floats(column), 0
    return _tolerant(column.cast(pa.string()).to_pylist(), decimal)


def _tolerant(cells: list[str | None], decimal: str) -> tuple[np.ndarray, int]:
    values, bad = np.full(len(cells), np.nan), 0
    for place, cell in enumerate(cells):
        if cell is not None and cell.strip():
            try:
                values[place] = float(cell.replace(",", ".") if decimal == "," else cell)
            except ValueError:
                bad += 1
    return values, bad


def _channels(
    data: bytes,
    layout: Layout,
    clocks: tuple[Clock, ...],
    units: dict[str, str],
    columns: dict[str, Column],
    names: Sequence[str],
) -> list[Channel]:
    timed = {name: clock for clock in clocks for name in clock.columns}
    needed = list(dict.fromkeys([*(timed[name].column for name in names), *names]))
    table, values, bad = _read(data, layout, needed)
    about = {told["name"]: told for told in layout.about.get("channels", {}).values()}
    stamps: dict[str, np.ndarray] = {}
    guesses: dict[str, str] = {}
    padded: dict[str, np.ndarray | None] = {}
    made = []
    for name in names:
        clock = timed[name]
        if clock.column not in stamps:
            if clock.column in values:
                time, guesses[clock.column] = seconds(values[clock.column], units[clock.column], clock.column)
            else:
                time = _calendar(table[clock.column], clock.column)
            padded[clock.column] = np.isfinite(time) if len(clocks) > 1 and not np.isfinite(time).all() else None
            kept = padded[clock.column]
            stamps[clock.column] = time if kept is None else time[kept]
        kept = padded[clock.column]
        column = values[name] if kept is None else values[name][kept]
        told = about.get(name, {})
        unit = columns[name].unit
        channel = Channel(name, stamps[clock.column], column, unit, told.get("source", name), told.get("note", ""))
        broken = f"{bad[name]} cells are no numbers" if bad.get(name) else ""
        made.append(channel.noted(guesses.get(clock.column, ""), broken))
    return made


def _calendar(column: Any, name: str) -> np.ndarray:
    import pyarrow as pa

    try:
        return calendar_seconds(column)
    except pa.ArrowException:
        odd = next((cell for cell in column.to_pylist() if not _ISO.match(str(cell))), column[0].as_py())
        raise InputError(
            f"the time column '{name}' holds '{str(odd)[:40]}' where dates read {DATES}: correct it, or give seconds"
        ) from None


def _head(data: bytes, layout: Layout) -> dict[str, np.ndarray]:
    """The beginning of the columns of numbers."""
    part = data[: layout.begin + (1 << 16)]
    part = part[: part.rfind(b"\n") + 1] if len(part) < len(data) else part
    return _read(part, layout, layout.numeric)[1] if len(part) > layout.begin else {}


def _count_broken(data: bytes, layout: Layout) -> str:
    """The note on lines that have another number of cells than the table has columns."""
    lines = data.count(b"\n", layout.begin) + (not data.endswith(b"\n"))
    broken: list[int] = []
    table = _as_found(data, layout, layout.numeric[:1] or layout.dates[:1], broken)
    if not broken:
        return ""
    return f"{len(broken)} of {max(lines, len(table))} lines are broken and were left out"
