"""Parquet, in a layout that can be read slice by slice.

Every group of channels with common time stamps has a time column ("time", "time.2", ...) followed by its channels.
Row groups cover equal slices of time; within one, shorter groups are padded with nulls at the end, and a row without a
time stamp is padding. The metadata of the schema hold units, sources and notes under the key "tierod", as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tierod.core.arrow import column_of, native_file
from tierod.core.errors import OutputError
from tierod.core.files import replacing
from tierod.io.layout import Writer
from tierod.io.writers.spool import ROWS, FromSpool, Spool, SpooledGroup

# Time that one row group covers [s]: short enough for the memory, long enough to read the file at full speed
SLICE = 60.0

_MOST = 100_000  # Largest number of row groups: a recording of days gets longer ones


def write_parquet(spool: Spool, path: str | Path) -> tuple[str, ...]:
    """Write a recording to a Parquet file.

    Args:
        path: the file; replaced as a whole

    Returns:
        what the format cannot hold: nothing
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    found = spool.groups()
    columns = [pair for group in found for pair in ((group.clock, "s"), *((c.name, c.unit) for c in group.channels))]
    about = json.dumps(spool.description(found) | {"slice_seconds": SLICE})
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in columns]
    schema = pa.schema(fields, metadata={"tierod": about})
    try:
        with (
            replacing(path) as temporary,
            native_file(temporary, "wb") as file,
            pq.ParquetWriter(file, schema, use_dictionary=False, write_page_checksum=True) as writer,
        ):
            for rows in _slices(found):
                length = max(last - first for first, last in rows)
                parts = []
                for group, (first, last) in zip(found, rows, strict=True):
                    parts += [column_of(each, length) for each in (group.time(first, last), *group.values(first, last))]
                # With so large a limit each table becomes one row group.
                writer.write_table(pa.table(parts, schema=schema), row_group_size=1 << 26)
    except pa.ArrowException as error:
        raise OutputError(f"{path} cannot be written: {' '.join(str(error).split())[:160]}") from None
    return ()


def _slices(found: tuple[SpooledGroup, ...]) -> Iterator[list[tuple[int, int]]]:
    """(first, end) rows of every group of channels for each row group, over equal slices of time."""
    ends = [(group.time(0, 1)[0], group.time(group.count - 1, group.count)[0]) for group in found if group.count]
    if not ends:
        yield [(0, 0) for _ in found]
        return
    start, stop = min(first for first, _ in ends), max(last for _, last in ends)
    seconds = max(SLICE, (stop - start) / _MOST)
    at = [0] * len(found)
    for number in range(1, int((stop - start) / seconds) + 2):
        edge = start + seconds * number
        rows = []
        for place, group in enumerate(found):
            end = at[place]
            while end < group.count:
                part = group.time(end, end + ROWS)
                inside = int(np.searchsorted(part, edge))
                end += inside
                if inside < len(part):
                    break
            rows.append((at[place], end))
            at[place] = end
        if any(last > first for first, last in rows):
            yield rows


WRITER = Writer("Parquet", FromSpool(write_parquet))
