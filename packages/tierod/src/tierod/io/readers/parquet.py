"""Parquet files through pyarrow: tierod's own layout (see `tierod.io.writers`), and any table with a time column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tierod.core.arrow import calendar_seconds, floats, is_number, native_file
from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.layout import description_in
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import Clock, find_clocks, require_plausible_rate, seconds, unit_of, unread_clock
from tierod.io.readers.limits import Allowance
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

Layout = Mapping[str, Any]  # Description of `tierod.io.layout`; empty in a file of another program

Result = TypeVar("Result")

# Key of the schema metadata that holds clocks, units, sources and notes of tierod's own layout, as JSON
LAYOUT = b"tierod"

_HEAD = 4096  # Number of rows from which the rate of a clock is estimated
BATCH = 1 << 17  # Number of rows that are read at a time, of all lanes together

# Size of the read buffers of all lanes together [bytes]: a mapped file or a read-ahead would all count as memory
_BUFFER = 1 << 20


def open_parquet(path: Path, time: TimeEntry = GUESSED) -> Source:
    """A Parquet file.

    Args:
        time: time column as given by a user; ignored in a file that tierod wrote
    """
    file = _opened(path)
    if not file.metadata.num_rows:
        raise InputError(f"{path} holds columns but no samples; record again")
    layout = _layout(file)
    time = GUESSED if layout else time
    if time.column is None:
        _refuse_text_as_clock(path, file, layout)
    try:
        clocks = find_clocks_of(file, layout, time)
        units = {
            column.name: "s" if layout else unit_of(column, time)
            for clock in clocks
            for column in _columns(file, layout)
            if column.name == clock.column
        }
        _require_plausible_rate(path, file, units)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return _source(path, file, layout, clocks, units)


def _opened(path: Path, lanes: int = 1) -> Any:
    """The file, opened with its share of the buffer."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        size = max(_BUFFER // lanes, 1 << 13)
        return pq.ParquetFile(native_file(path), pre_buffer=False, buffer_size=size, page_checksum_verification=True)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"{path} is damaged or cut off and cannot be read as Parquet ({reason}); write it again"
        ) from None


def _require_plausible_rate(path: Path, file: pq.ParquetFile, units: dict[str, str]) -> None:
    if all(units.values()) or not all(is_number(file.schema_arrow.field(name).type) for name in units):
        return
    batches = file.iter_batches(_HEAD, row_groups=[0], columns=list(units))
    batch = _guarded(path, lambda: next(batches, None))
    if batch is not None:
        require_plausible_rate((name, unit, floats(batch[name])) for name, unit in units.items())


def _refuse_text_as_clock(path: Path, file: pq.ParquetFile, layout: Layout) -> None:
    if layout:
        return
    usable = _columns(file, layout)
    known = {column.name for column in usable}
    clock = unread_clock([Column(name) for name in file.schema_arrow.names if name not in known], usable)
    if clock is not None:
        raise InputError(
            f"{path}: the time column '{clock.name}' holds values of type {file.schema_arrow.field(clock.name).type}; "
            "write it as time stamps (timestamp) or as numbers in seconds"
        )


def _layout(file: pq.ParquetFile) -> Layout:
    """tierod's own description; empty where it does not fit the columns, since another program changed the file."""
    try:
        layout = description_in((file.schema_arrow.metadata or {}).get(LAYOUT, b"{}"))
        usable = {column.name for column in _columns(file, {})}
        fits = layout["layout"] == 1 and layout["clocks"] and all(each["time"] in usable for each in layout["clocks"])
    except (ValueError, KeyError, TypeError):
        return {}
    return layout if fits else {}


def find_clocks_of(file: pq.ParquetFile, layout: Layout, time: TimeEntry = GUESSED) -> tuple[Clock, ...]:
    """The clocks that the layout names, that the user gives, or that the names of the columns indicate.

    Args:
        layout: description that tierod wrote; empty where another program wrote the file
    """
    columns = [column for column in _columns(file, layout) if not column.name.startswith("__index")]
    if not layout:
        return find_clocks(columns, given=time)
    clocks = tuple(Clock(clock["time"], tuple(clock["channels"])) for clock in layout["clocks"])
    added = _added(columns, clocks)
    return (Clock(clocks[0].column, (*clocks[0].columns, *added)),) if len(clocks) == 1 else clocks


def _added(columns: Sequence[Column], clocks: Sequence[Clock]) -> tuple[str, ...]:
    known = {name for clock in clocks for name in (clock.column, *clock.columns)}
    return tuple(column.name for column in columns if column.name not in known)


def _columns(file: pq.ParquetFile, layout: Layout) -> list[Column]:
    import pyarrow.types as types

    found = []
    for item in file.schema_arrow:
        if is_number(item.type) or types.is_timestamp(item.type):
            notes = {_text(key).lower(): _text(value) for key, value in (item.metadata or {}).items()}
            unit = layout.get("channels", {}).get(item.name, {}).get("unit", notes.get("unit", notes.get("units", "")))
            found.append(Column(item.name, unit))
    return found


def texts_of(schema: pa.Schema) -> tuple[str, ...]:
    """Names of columns that hold neither numbers nor time stamps."""
    import pyarrow.types as types

    return tuple(item.name for item in schema if not (is_number(item.type) or types.is_timestamp(item.type)))


def _text(written: bytes) -> str:
    return written.decode("utf-8", "replace")


def _source(
    path: Path, file: pq.ParquetFile, layout: Layout, clocks: tuple[Clock, ...], units: dict[str, str]
) -> Source:
    columns = {column.name: column for column in _columns(file, layout)}
    numbers = {name for name in columns if is_number(file.schema_arrow.field(name).type)}
    timed = {name: clock for clock in clocks for name in clock.columns if name in numbers}
    notes = layout.get("channels", {})

    def channels(table: pa.RecordBatch, names: Sequence[str]) -> list[Channel]:
        clock = timed[names[0]].column  # the columns of a lane have the same clock
        table = _without_padding(table, clock)
        time, kept, guess = _stamps(table[clock], units[clock], clock)
        made = []
        for name in names:
            values = floats(table[name])
            about = notes.get(name, {})
            values = values if kept is None else values[kept]
            origin = (about.get("source", name), about.get("note", ""))
            made.append(Channel(name, time, values, columns[name].unit, *origin).noted(guess))
        return made

    def lane(names: Sequence[str], number: int) -> Lane:
        needed = list(dict.fromkeys([*(timed[name].column for name in names), *names]))
        opened = _opened(path, number)
        _refuse_large(path, opened, needed)
        for batch, share in _batches(path, opened, needed, max(BATCH // number, 1 << 10)):
            yield Piece(channels(batch, names), share)

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock: dict[str, list[str]] = {}
        for name in names:
            by_clock.setdefault(timed[name].column, []).append(name)
        return [lane(members, len(by_clock)) for members in by_clock.values()]

    metadata = {**layout.get("metadata", {}), "format": "Parquet"}
    used = tuple(columns[name] for name in timed)
    texts = texts_of(file.schema_arrow)
    return Source(used, lanes, metadata, float(layout.get("origin", 0.0)), _left_out(columns, clocks), texts=texts)


def _batches(
    path: Path, file: pq.ParquetFile, columns: Sequence[str], size: int
) -> Iterator[tuple[pa.RecordBatch, float]]:
    """(rows of the columns, of which the first is the clock; share of the file that is done).

    A slow clock beside a fast one has padding at the end of every row group, for a bus beside a sensor of 1 kHz ten
    rows per sample; it is not unpacked.
    """
    padding = _padding(file, columns[0])
    rows, done = file.metadata.num_rows, 0
    groups = [[group] for group in range(len(padding))] if any(padding) else [list(range(len(padding)))]
    for group in groups:
        of_group = sum(file.metadata.row_group(each).num_rows for each in group)
        stamps, read = of_group - sum(padding[each] for each in group), 0
        # One row more than the stamps: only padding in it confirms that the statistics are right.
        # One thread: with several, the C library keeps 40 MB per process.
        most = min(size, max(stamps + 1, _HEAD))
        batches = file.iter_batches(most, row_groups=group, columns=columns, use_threads=False)
        while (batch := _guarded(path, partial(next, batches, None))) is not None:
            stamps, read = stamps - batch.num_rows + batch.column(0).null_count, read + batch.num_rows
            yield batch, min((done + read) / rows, 1.0)
            if not stamps and batch.column(0).null_count:
                break
        done += of_group


def _without_padding(table: pa.RecordBatch, clock: str) -> pa.RecordBatch:
    """The rows up to the last stamp of the clock, where all rows without a stamp are at the end."""
    stamps = table[clock]
    stamped = len(stamps) - stamps.null_count
    return table.slice(0, stamped) if stamps.null_count and not stamps.slice(0, stamped).null_count else table


def _padding(file: pq.ParquetFile, clock: str) -> list[int]:
    """Number of rows without a stamp in every row group, from its statistics; 0 where these are missing."""
    about = file.metadata
    place = next(place for place in range(about.num_columns) if about.schema.column(place).path == clock)
    found = [about.row_group(group).column(place).statistics for group in range(about.num_row_groups)]
    return [each.null_count if each is not None and each.has_null_count else 0 for each in found]


def _refuse_large(path: Path, file: pq.ParquetFile, needed: Sequence[str]) -> None:
    """Refuse columns that are too large when unpacked, by the metadata of the file, before anything is unpacked."""
    about = file.metadata
    places = [place for place in range(about.num_columns) if about.schema.column(place).path in needed]
    # The samples and the unpacked pages are checked separately: repeated values make pages small and samples many.
    allowance = Allowance(path, path.stat().st_size)
    allowance.take(8 * len(places) * about.num_rows)
    allowance = Allowance(path, path.stat().st_size)
    for group in range(about.num_row_groups):
        for place in places:
            allowance.take(about.row_group(group).column(place).total_uncompressed_size)


def _left_out(columns: dict[str, Column], clocks: Sequence[Clock]) -> tuple[str, ...]:
    added = _added([column for column in columns.values() if not column.name.startswith("__index")], clocks)
    if not added:
        return ()
    names = ", ".join(f"'{name}'" for name in added)
    return (f"{names} added to a file with several clocks, left out: write them with tierod.write",)


def _guarded(path: Path, work: Callable[[], Result]) -> Result:
    import pyarrow as pa

    try:
        return work()
    except (pa.ArrowException, OSError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is damaged and cannot be read to its end ({reason}); write it again") from None


def _stamps(column: pa.Array, unit: str, name: str) -> tuple[np.ndarray, np.ndarray | None, str]:
    """(time [s], mask of the rows with a stamp or None for all, note on a guessed unit); other rows are padding."""
    import pyarrow.types as types

    calendar = types.is_timestamp(column.type)
    time, guess = (calendar_seconds(column), "") if calendar else seconds(floats(column), unit, name)
    if not column.null_count:
        return time, None, guess
    kept = np.isfinite(time)
    return time[kept], kept, guess


FORMAT = Format(
    "parquet",
    "Parquet (.parquet, .pq)",
    (".parquet", ".pq"),
    lambda content, time: open_parquet(content.path, time),
    begins_with(b"PAR1"),
    whole=True,
)
