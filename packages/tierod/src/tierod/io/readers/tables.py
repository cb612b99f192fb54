"""Parquet and Arrow IPC (Feather) files through pyarrow: tierod's own layout, and any table with a time column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tierod.core.errors import InputError
from tierod.core.frames import calendar_seconds, floats, is_number, native_file
from tierod.core.recording import Channel
from tierod.core.units import split_name
from tierod.io.formats import description_in
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import (
    PACKED,
    Clock,
    OwnRates,
    find_clocks,
    is_packed,
    require_plausible_rate,
    seconds,
    unit_of,
    unread_clock,
)
from tierod.io.readers.content import Allowance
from tierod.io.readers.source import Column, Format, Lane, Piece, Source, begins_with

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

Layout = Mapping[str, Any]  # Description of `tierod.io.formats`; empty in a file of another program

Result = TypeVar("Result")

LAYOUT = b"tierod"  # key of the schema metadata that holds clocks, units, sources and notes of tierod's own layout
HEAD = 4096  # rows from which the rate of a clock is estimated
BATCH = 1 << 17  # rows that are read at a time, of all lanes together
BUFFER = 1 << 20  # bytes of the read buffers of all lanes: a mapped file or a read-ahead would all count as memory


class _Table:
    """Columns and clocks by the schema of pyarrow."""

    def __init__(self, schema: pa.Schema, layout: Layout, time: TimeEntry):
        import pyarrow.types as types

        self.layout, self.columns = layout, dict[str, Column]()
        for item in schema:
            if is_number(item.type) or types.is_timestamp(item.type):
                notes = {_text(key).lower(): _text(value) for key, value in (item.metadata or {}).items()}
                known = layout.get("channels", {}).get(item.name, {})
                unit = known.get("unit", notes.get("unit", notes.get("units", "")))
                bare, inside = ("", "") if layout else split_name(item.name)
                self.columns[item.name] = Column(item.name, unit or inside, bare)
        self.texts = tuple(name for name in schema.names if name not in self.columns)
        self.numbers = {name for name in self.columns if is_number(schema.field(name).type)}
        self._schema = schema
        self.clocks = self._clocks(time)
        self.units = {
            clock.column: "s" if layout else unit_of(self.columns[clock.column], time) for clock in self.clocks
        }
        self.clock_of = {name: clock.column for clock in self.clocks for name in clock.columns if name in self.numbers}

    @property
    def used(self) -> tuple[Column, ...]:
        return tuple(self.columns[name] for name in self.clock_of)

    def _clocks(self, time: TimeEntry) -> tuple[Clock, ...]:
        """The clocks that the layout names, that the user gives, or that the names of the columns indicate."""
        if self.layout:
            clocks = tuple(Clock(clock["time"], tuple(clock["channels"])) for clock in self.layout["clocks"])
            return (Clock(clocks[0].column, (*clocks[0].columns, *self.added(clocks))),) if len(clocks) == 1 else clocks
        columns = [column for column in self.columns.values() if not column.name.startswith("__index")]
        clock = None if time.column else unread_clock([Column(name) for name in self.texts], columns)
        if clock is not None:
            raise InputError(
                f"the time column '{clock.name}' holds values of type {self._schema.field(clock.name).type}; "
                "write it as time stamps (timestamp) or as numbers in seconds"
            )
        return find_clocks(columns, given=time)

    def added(self, clocks: Sequence[Clock]) -> tuple[str, ...]:
        """Columns that another program added to a file that tierod wrote."""
        known = {name for clock in clocks for name in (clock.column, *clock.columns)}
        return tuple(name for name in self.columns if name not in known and not name.startswith("__index"))

    def require_plausible_rate(self, first: Callable[[list[str]], Any]) -> None:
        """Refuse doubtful clocks, by the first rows."""
        plain = [(name, unit) for name, unit in self.units.items() if not unit and name in self.numbers]
        if len(plain) == len(self.units) and (batch := first(list(self.units))) is not None:
            require_plausible_rate((name, unit, floats(batch[name])[:HEAD]) for name, unit in plain)

    def channels(self, batch: pa.RecordBatch, names: Sequence[str]) -> list[Channel]:
        stamps: dict[str, tuple[np.ndarray, np.ndarray | None, str]] = {}
        notes = self.layout.get("channels", {})
        made = []
        for name in names:
            clock = self.clock_of[name]
            if clock not in stamps:
                stamps[clock] = _stamps(batch[clock], self.units[clock], clock)
            time, kept, guess = stamps[clock]
            values, about = floats(batch[name]), notes.get(name, {})
            values = values if kept is None else values[kept]
            origin = (about.get("source", name), about.get("note", ""))
            made.append(Channel(name, time, values, self.columns[name].unit, *origin).noted(guess))
        return made


def _text(written: bytes) -> str:
    return written.decode("utf-8", "replace")


def _stamps(column: pa.Array, unit: str, name: str) -> tuple[np.ndarray, np.ndarray | None, str]:
    """(time [s], mask of the rows with a stamp or None for all, note on a guessed unit); other rows are padding."""
    import pyarrow.types as types

    calendar = types.is_timestamp(column.type)
    time, guess = (calendar_seconds(column), "") if calendar else seconds(floats(column), unit, name)
    if not column.null_count:
        return time, None, guess
    kept = np.isfinite(time)
    return time[kept], kept, guess


def _guarded(path: Path, kind: str, work: Callable[[], Result]) -> Result:
    import pyarrow as pa

    try:
        return work()
    except (pa.ArrowException, OSError, UnicodeDecodeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        large = isinstance(error, MemoryError)  # one of the errors of pyarrow is
        reason = "a block claims to be larger than the memory" if large else " ".join(str(error).split())[:120]
        raise InputError(
            f"{path} is damaged or cut off and cannot be read as {kind} ({reason}); write it again"
        ) from None


def _table(
    path: Path, kind: str, schema: pa.Schema, layout: Layout, time: TimeEntry, first: Callable[[list[str]], Any]
) -> _Table:
    try:
        table = _guarded(path, kind, lambda: _Table(schema, layout, GUESSED if layout else time))
        table.require_plausible_rate(lambda names: _guarded(path, kind, lambda: first(names)))
    except InputError as error:
        raise InputError(f"{path}: {error}" if str(path) not in str(error) else str(error)) from None
    return table


def open_parquet(path: Path, time: TimeEntry = GUESSED) -> Source:
    """A Parquet file; the time column that a user gives is ignored in a file that tierod wrote."""
    file = _opened(path)
    if not file.metadata.num_rows:
        raise InputError(f"{path} holds columns but no samples; record again")
    layout = _layout(file.schema_arrow)

    def first(names: list[str]) -> Any:
        return next(file.iter_batches(HEAD, row_groups=[0], columns=names), None)

    table = _table(path, "Parquet", file.schema_arrow, layout, time, first)
    for clock, unit in table.units.items():
        batches = _batches(path, file, [clock], BATCH) if not unit and clock in table.numbers else iter(())
        table.units[clock] = PACKED if is_packed(floats(batch[clock]) for batch, _ in batches) else unit

    def lane(names: Sequence[str], number: int) -> Lane:
        needed = list(dict.fromkeys([*(table.clock_of[name] for name in names), *names]))
        opened = _opened(path, number)
        _refuse_large(path, opened, needed)
        own_rates = OwnRates()
        for batch, share in _batches(path, opened, needed, max(BATCH // number, 1 << 10)):
            channels = table.channels(_without_padding(batch), names)
            yield Piece(channels if layout else own_rates(channels), share)

    def lanes(names: Sequence[str]) -> list[Lane]:
        by_clock: dict[str, list[str]] = {}
        for name in names:
            by_clock.setdefault(table.clock_of[name], []).append(name)
        return [lane(members, len(by_clock)) for members in by_clock.values()]

    added = ", ".join(f"'{name}'" for name in table.added(table.clocks)) if layout else ""
    warnings = (f"{added} added to a file with several clocks, left out: write them with tierod.write",) * bool(added)
    metadata = {**layout.get("metadata", {}), "format": "Parquet"}
    return Source(table.used, lanes, metadata, float(layout.get("origin", 0.0)), warnings, texts=table.texts)


def _opened(path: Path, lanes: int = 1) -> Any:
    """The file, opened with its share of the buffer."""
    import pyarrow.parquet as pq

    def opened() -> Any:
        size = max(BUFFER // lanes, 1 << 13)
        return pq.ParquetFile(native_file(path), pre_buffer=False, buffer_size=size, page_checksum_verification=True)

    return _guarded(path, "Parquet", opened)


def _layout(schema: pa.Schema) -> Layout:
    """tierod's own description; empty where it does not fit the columns, since another program changed the file."""
    import pyarrow.types as types

    try:
        layout = description_in((schema.metadata or {}).get(LAYOUT, b"{}"))
        usable = {item.name for item in schema if is_number(item.type) or types.is_timestamp(item.type)}
        fits = layout["layout"] == 1 and layout["clocks"] and all(each["time"] in usable for each in layout["clocks"])
    except (ValueError, KeyError, TypeError):
        return {}
    return layout if fits else {}


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
        most = min(size, max(stamps + 1, HEAD))
        batches = file.iter_batches(most, row_groups=group, columns=columns, use_threads=False)
        while (batch := _guarded(path, "Parquet", partial(next, batches, None))) is not None:
            batch = batch.select(columns)
            stamps, read = stamps - batch.num_rows + batch.column(0).null_count, read + batch.num_rows
            yield batch, min((done + read) / rows, 1.0)
            if not stamps and batch.column(0).null_count:
                break
        done += of_group


def _without_padding(batch: pa.RecordBatch) -> pa.RecordBatch:
    """The rows up to the last stamp of the first column, where all rows without a stamp are at the end."""
    stamps = batch.column(0)
    stamped = len(stamps) - stamps.null_count
    return batch.slice(0, stamped) if stamps.null_count and not stamps.slice(0, stamped).null_count else batch


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
    Allowance(path, path.stat().st_size).take(8 * len(places) * about.num_rows)
    allowance = Allowance(path, path.stat().st_size)
    for group in range(about.num_row_groups):
        for place in places:
            allowance.take(about.row_group(group).column(place).total_uncompressed_size)


def open_arrow(path: Path, time: TimeEntry = GUESSED) -> Source:
    """An Arrow IPC file (Feather 2) or stream; a stream that is cut off is read up to its last batch."""
    schema, first = _guarded(path, "Arrow", lambda: _stream(path))
    head = _guarded(path, "Arrow", lambda: _next(first))
    table = _table(path, "Arrow", schema, {}, time, lambda _: head)
    if head is None:
        raise InputError(f"{path}: it holds columns but no samples; record again")
    lost: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        lost.clear()
        return [lane(names)]

    def lane(names: Sequence[str]) -> Lane:
        allowance, given, own_rates = Allowance(path, path.stat().st_size), False, OwnRates()
        _, batches = _guarded(path, "Arrow", lambda: _stream(path))
        while True:
            try:
                batch = _guarded(path, "Arrow", lambda: _next(batches))
            except InputError:
                if not given:
                    raise
                lost.append("the file is cut off or damaged: the data before that were read")
                return
            if batch is None:
                return
            allowance.take(8 * (len(names) + 1) * batch.num_rows)
            for begin in range(0, batch.num_rows, BATCH):
                given = True
                yield Piece(own_rates(table.channels(batch.slice(begin, BATCH), names)), 0.5)

    return Source(table.used, lanes, {"format": "Arrow"}, 0.0, (), lambda: tuple(lost), texts=table.texts)


def _stream(path: Path) -> tuple[Any, Iterator[Any]]:
    """(schema, record batches) of a file or a stream."""
    import pyarrow as pa

    with path.open("rb") as head:
        is_file = head.read(6) == b"ARROW1"
    # Read, not mapped: pages of a mapped file would count as memory.
    source = native_file(path)
    if is_file:
        reader = pa.ipc.open_file(source)
        return reader.schema, (reader.get_batch(number) for number in range(reader.num_record_batches))
    stream = pa.ipc.open_stream(source)
    return stream.schema, iter(stream)


def _next(batches: Iterator[Any]) -> Any:
    """The next batch, None at the end; pyarrow by itself does not check the sizes in a batch against its bytes."""
    batch = next(batches, None)
    if batch is not None:
        batch.validate()
    return batch


PARQUET = Format(
    "parquet", "Parquet (.parquet, .pq)", (".parquet", ".pq"), lambda content, time: open_parquet(content.path, time),
    begins_with(b"PAR1"), whole=True,
)  # fmt: skip
_ARROW = (".arrow", ".feather", ".arrows", ".ipc")
ARROW = Format(
    "arrow", "Arrow IPC, Feather (.arrow, .feather)", _ARROW, lambda content, time: open_arrow(content.path, time),
    lambda head, ending: head.startswith(b"ARROW1") or (head.startswith(b"\xff\xff\xff\xff") and ending in _ARROW),
    whole=True,
)  # fmt: skip
