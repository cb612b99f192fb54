"""Estimates over time in levels, each four times as fine as the one before, so that any zoom reads little.

table = zoom("results", key, "friction_torque", 120.0, 180.0, points=600)
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tierod.core.decimation import bin_width, coarser
from tierod.core.errors import InputError
from tierod.core.findings import Trace
from tierod.fleet import schema
from tierod.fleet.places import place_of

if TYPE_CHECKING:
    import pyarrow as pa

FINEST: Annotated[float, "s"] = 1.0  # Bin width of the finest level; estimates change more slowly

FACTOR = 4  # Number of bins that are merged into one of the next coarser level

COARSEST = 64  # Largest number of bins of the coarsest level

GROUP = 4096  # Rows of a row group, the smallest unit that is read: 80 kB, and more than a screen has columns


def path_of(key: str) -> str:
    """Path of the levels of a result in the results folder."""
    return f"levels/{key[:2]}/{key}.parquet"


def pyramid(trace: Trace) -> list[Trace]:
    """Levels of a trace, the coarsest first."""
    width = bin_width(trace)
    levels = [coarser(trace, max(round(FINEST / width), 1) if width > 0.0 else 1)]
    while len(levels[0].time) > COARSEST:
        levels.insert(0, coarser(levels[0], FACTOR))
    return levels


def content_of(estimates: Mapping[str, Mapping[str, Trace]]) -> bytes:
    """Content of the file with the levels of one result."""
    import pyarrow.parquet as pq

    buffer = io.BytesIO()
    with pq.ParquetWriter(
        buffer, schema.levels(), compression="zstd", use_dictionary=["monitor", "name", "unit"]
    ) as out:
        for table in _tables(estimates):
            out.write_table(table, row_group_size=GROUP)
    return buffer.getvalue()


def _tables(estimates: Mapping[str, Mapping[str, Trace]]) -> Iterator[pa.Table]:
    import pyarrow as pa

    made = [(monitor, each) for monitor, traces in estimates.items() for each in map(pyramid, traces.values())]
    for level in range(max((len(each) for _, each in made), default=0)):
        parts = [(monitor, each[level]) for monitor, each in made if level < len(each)]
        counts = [len(trace.time) for _, trace in parts]
        texts = [[monitor for monitor, _ in parts], [t.name for _, t in parts], [t.unit for _, t in parts]]
        columns = [pa.DictionaryArray.from_arrays(np.repeat(np.arange(len(parts)), counts), each) for each in texts]
        columns = [each.dictionary_decode() for each in columns]
        columns.append(pa.array(np.full(sum(counts), level, np.int8)))
        columns.append(pa.array(np.concatenate([np.asarray(trace.time, float) for _, trace in parts])))
        for side in ("lower", "upper", "mean"):
            values = np.concatenate([np.asarray(getattr(trace, side), np.float32) for _, trace in parts])
            columns.append(pa.array(values, mask=np.isnan(values)))
        yield pa.table(columns, schema=schema.levels())


def zoom(
    results: str | Path, key: str, name: str, start: float = -np.inf, stop: float = np.inf, points: int = 1000
) -> pa.Table:
    """An estimate over a time span, at the coarsest level that has the required number of points."""
    import pyarrow.parquet as pq

    place = place_of(results)
    try:
        with place.open(path_of(key)) as source:
            file = pq.ParquetFile(source)
            if schema.version_in(file.schema_arrow, "levels") is None:
                raise InputError(f"{place.shown(path_of(key))} holds no levels; run 'tierod fleet' again")
            found = None
            for groups in _by_level(file, name, start, stop).values():
                table = file.read_row_groups(groups).filter(_within(name, start, stop))
                found = table if found is None or len(table) else found
                if len(table) >= points:
                    break
    except OSError:
        raise InputError(
            f"{place.shown(path_of(key))} is not there; levels are written by 'tierod fleet' without --no-levels"
        ) from None
    if found is None or not len(found):
        raise InputError(f"{place.shown(path_of(key))} holds no estimate '{name}' between {start:g} and {stop:g} s")
    return found


def _by_level(file: pa.parquet.ParquetFile, name: str, start: float, stop: float) -> dict[int, list[int]]:
    """Row groups that may hold the wanted rows, by level, the coarsest first, from their statistics alone."""
    order = {column: place for place, column in enumerate(file.schema_arrow.names)}
    groups: dict[int, list[int]] = {}
    for number in range(file.metadata.num_row_groups):
        group = file.metadata.row_group(number)
        names, level, time = (group.column(order[each]).statistics for each in ("name", "level", "time_s"))
        # Statistics of times apply to one name only if the group holds no other.
        one = names.min == names.max
        if names.min <= name <= names.max and not (one and (time.min > stop or time.max < start)):
            groups.setdefault(level.min, []).append(number)
    return dict(sorted(groups.items()))


def _within(name: str, start: float, stop: float) -> pa.compute.Expression:
    import pyarrow.compute as pc

    return (pc.field("name") == name) & (pc.field("time_s") >= start) & (pc.field("time_s") < stop)
