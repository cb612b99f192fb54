"""Parquet, in a layout that can be read slice by slice.

Every group of channels with common time stamps has a time column ("time", "time.2", ...) followed by its channels.
Row groups cover equal slices of time; within one, shorter groups are padded with nulls at the end, and a row without a
time stamp is padding. Units, sources and notes stand in the metadata of the schema under the key "tierod", as JSON.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tierod.core.arrow import column_of
from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.core.recording import Recording
from tierod.io.layout import Group, Writer, description, groups

if TYPE_CHECKING:
    import pyarrow as pa

SLICE = 60.0
"""Time that one row group covers [s]: small enough for memory, large enough for the file to be read at full speed."""

_MOST = 100_000
"""Row groups at the most: a recording of days gets longer ones."""


def write_parquet(recording: Recording, path: str | Path, slice_seconds: float = SLICE) -> None:
    """Write a recording to a Parquet file.

    Args:
        recording: with at least one channel
        path: the file; replaced as a whole
        slice_seconds: time that one row group covers [s]

    Raises:
        OutputError: nothing to write, a slice that is not positive, or the file cannot be written
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not slice_seconds > 0.0:
        raise OutputError(f"row groups need a positive time, not {slice_seconds} s")
    found = groups(recording)
    about = description(recording, found) | {"slice_seconds": slice_seconds}
    schema = pa.schema(
        [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in _fields(found)],
        metadata={"tierod": json.dumps(about)},
    )
    try:
        with (
            replacing(path) as temporary,
            pq.ParquetWriter(temporary, schema, use_dictionary=False, write_page_checksum=True) as writer,
        ):
            for rows in _slices(found, slice_seconds):
                writer.write_table(_table(schema, found, rows), row_group_size=1 << 26)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None


def _fields(found: tuple[Group, ...]) -> list[tuple[str, str]]:
    return [field for group in found for field in ((group.clock, "s"), *((c.name, c.unit) for c in group.channels))]


def _slices(found: tuple[Group, ...], seconds: float) -> list[list[tuple[int, int]]]:
    """Per row group the (first, last) rows of every group."""
    times = [group.time for group in found if len(group.time)]
    if not times:
        return [[(0, 0) for _ in found]]
    start, stop = min(float(time[0]) for time in times), max(float(time[-1]) for time in times)
    count = min(int((stop - start) / seconds) + 1, _MOST)
    edges = start + max(seconds, (stop - start) / _MOST) * np.arange(1, count)
    bounds = [np.concatenate(([0], np.searchsorted(group.time, edges), [len(group.time)])) for group in found]
    rows = [[(int(b[k]), int(b[k + 1])) for b in bounds] for k in range(count)]
    return [row for row in rows if any(last > first for first, last in row)]


def _table(schema: pa.Schema, found: tuple[Group, ...], rows: list[tuple[int, int]]) -> pa.Table:
    import pyarrow as pa

    length = max(last - first for first, last in rows)
    columns = []
    for group, (first, last) in zip(found, rows, strict=True):
        for values in (group.time, *(channel.values for channel in group.channels)):
            columns.append(column_of(values[first:last], length))
    return pa.table(columns, schema=schema)


WRITER = Writer("Parquet", write_parquet)
