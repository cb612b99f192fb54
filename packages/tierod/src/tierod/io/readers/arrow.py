"""Arrow IPC files and streams (Feather) through pyarrow: a table with a time column, batch by batch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np

from tierod.core.arrow import floats, is_number, native_file
from tierod.core.errors import InputError
from tierod.core.recording import Channel
from tierod.io.readers.channel_map import GUESSED, TimeEntry
from tierod.io.readers.clocks import require_plausible_rate, unit_of
from tierod.io.readers.limits import Allowance
from tierod.io.readers.parquet import _columns, _stamps, find_clocks_of, texts_of
from tierod.io.readers.source import Column, Format, Lane, Piece, Source

ROWS = 1 << 17  # Number of rows of a piece

Result = TypeVar("Result")


def open_arrow(path: Path, time: TimeEntry = GUESSED) -> Source:
    """An Arrow IPC file (Feather 2) or stream; a stream that is cut off is read up to its last batch."""
    schema, first = _guarded(path, lambda: _opened(path))
    file = SimpleNamespace(schema_arrow=schema)
    columns = {column.name: column for column in _guarded(path, lambda: _columns(file, {}))}
    try:
        clocks = find_clocks_of(file, {}, time)
        units = {clock.column: unit_of(columns[clock.column], time) for clock in clocks}
        head = _guarded(path, lambda: _next(first))
        if head is None:
            raise InputError("it holds columns but no samples; record again")
        plain = [(name, unit) for name, unit in units.items() if not unit and is_number(schema.field(name).type)]
        require_plausible_rate((name, unit, floats(head.column(name))[:4096]) for name, unit in plain)
    except InputError as error:
        raise InputError(f"{path}: {error}" if str(path) not in str(error) else str(error)) from None
    numbers = {name for name in columns if is_number(schema.field(name).type)}
    clock_of = {name: clock.column for clock in clocks for name in clock.columns if name in numbers}
    lost: list[str] = []

    def lanes(names: Sequence[str]) -> list[Lane]:
        lost.clear()
        return [_lane(path, [columns[name] for name in names], clock_of, units, lost)]

    used = tuple(columns[name] for name in clock_of)
    texts = texts_of(schema)
    return Source(used, lanes, {"format": "Arrow"}, 0.0, (), lambda: tuple(lost), texts=texts)


def _opened(path: Path) -> tuple[Any, Iterator[Any]]:
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


def _lane(
    path: Path, columns: Sequence[Column], clock_of: dict[str, str], units: dict[str, str], lost: list[str]
) -> Lane:
    allowance = Allowance(path, path.stat().st_size)
    _, batches = _guarded(path, lambda: _opened(path))
    given = False
    while True:
        try:
            batch = _guarded(path, lambda: _next(batches))
        except InputError:
            if not given:
                raise
            lost.append("the file is cut off or damaged: the data before that were read")
            return
        if batch is None:
            return
        allowance.take(8 * (len(columns) + 1) * batch.num_rows)
        for begin in range(0, batch.num_rows, ROWS):
            given = True
            yield Piece(_channels(batch.slice(begin, ROWS), columns, clock_of, units), 0.5)


def _channels(batch: Any, columns: Sequence[Column], clock_of: dict[str, str], units: dict[str, str]) -> list[Channel]:
    stamps: dict[str, tuple[np.ndarray, np.ndarray | None, str]] = {}
    made = []
    for column in columns:
        clock = clock_of[column.name]
        if clock not in stamps:
            stamps[clock] = _stamps(batch.column(clock), units[clock], clock)
        time, kept, guess = stamps[clock]
        values = floats(batch.column(column.name))
        values = values if kept is None else values[kept]
        made.append(Channel(column.name, time, values, column.unit, column.name).noted(guess))
    return made


def _next(batches: Iterator[Any]) -> Any:
    """The next batch, None at the end; pyarrow by itself does not check the sizes in a batch against its bytes."""
    batch = next(batches, None)
    if batch is not None:
        batch.validate()
    return batch


def _guarded(path: Path, work: Callable[[], Result]) -> Result:
    import pyarrow as pa

    try:
        return work()
    except (pa.ArrowException, OSError, UnicodeDecodeError, ValueError) as error:
        large = isinstance(error, MemoryError)  # one of the errors of pyarrow is
        reason = "a block claims to be larger than the memory" if large else " ".join(str(error).split())[:120]
        raise InputError(
            f"{path} is damaged or cut off and cannot be read as Arrow ({reason}); write it again"
        ) from None


def _recognised(head: bytes, ending: str) -> bool:
    return head.startswith(b"ARROW1") or (head.startswith(b"\xff\xff\xff\xff") and ending in FORMAT.endings)


FORMAT = Format(
    "arrow",
    "Arrow IPC, Feather (.arrow, .feather)",
    (".arrow", ".feather", ".arrows", ".ipc"),
    lambda content, time: open_arrow(content.path, time),
    _recognised,
    whole=True,
)
