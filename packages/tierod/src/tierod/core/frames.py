"""Recordings as tables of other libraries: Arrow, pandas, Polars, xarray.

Channels with different time stamps become columns over all of them: null (in pandas and xarray NaN) where a channel
has no sample, NaN where its sample is missing. Units, sources and notes are kept where the library can store them.
"""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from tierod.core.errors import InputError, MissingExtra, nearest

if TYPE_CHECKING:
    import pandas
    import pyarrow as pa
    import xarray


TIME = "time"  # Name of the column, index or coordinate of the time stamps [s]
KEY = "tierod"  # Key in the metadata of a table under which units, sources and notes are kept


class Column(NamedTuple):
    """A column of a table with its time stamps, from which a channel is made."""

    name: str
    time: np.ndarray
    values: np.ndarray
    unit: str
    source: str
    note: str


def library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise MissingExtra(name, "frames", f"a recording as a table of {name}") from None


def to_arrow(channels: Iterable[Column]) -> Any:
    """A pyarrow Table with a column of time stamps and one for every channel.

    Args:
        channels: channels of a recording; none may be called "time"
    """
    import pyarrow as pa

    signals = list(channels)
    time, places = _joined(signals)
    columns, fields = [column_of(time)], [pa.field(TIME, pa.float64(), metadata={"unit": "s"})]
    for each, at in zip(signals, places, strict=True):
        if len(at) == len(time):
            columns.append(column_of(each.values))
        else:
            values, absent = np.zeros(len(time)), np.ones(len(time), dtype=bool)
            values[at], absent[at] = each.values, False
            columns.append(pa.array(values, mask=absent, from_pandas=False))
        fields.append(pa.field(each.name, pa.float64(), metadata={"unit": each.unit}))
    return pa.table(columns, schema=pa.schema(fields, metadata={KEY: json.dumps(_about(signals))}))


def from_arrow(data: object, time: str = TIME, units: Mapping[str, str] | None = None) -> list[Column]:
    """The columns of any table that has the Arrow PyCapsule interface: pyarrow, pandas, Polars, DuckDB and others.

    Args:
        data: the table; a null is no sample, NaN is a missing one
        time: name of the column of time stamps [s]
        units: units by column name; those of the table where not given
    """
    import pyarrow as pa

    if not hasattr(data, "__arrow_c_stream__") and not isinstance(data, pa.Table):
        raise InputError(f"a table of the type '{type(data).__name__}' has no Arrow interface; give a data frame")
    table = pa.table(data)
    if time not in table.column_names:
        raise InputError(f"the table has no column '{time}'{nearest(time, table.column_names)} Give time=...")
    about = json.loads((table.schema.metadata or {}).get(KEY.encode(), b"{}"))
    stamps = _numbers(table, time)
    clocks: dict[bytes, np.ndarray] = {}
    found = []
    for field in table.schema:
        if field.name == time:
            continue
        column = table[field.name]
        seen = ~np.asarray(column.is_null().combine_chunks()) if column.null_count else np.ones(len(stamps), bool)
        # Channels that share their stamps share the array.
        clock = clocks.setdefault(seen.tobytes(), stamps if seen.all() else stamps[seen])
        entry = about.get(field.name, {})
        unit = (units or {}).get(field.name, entry.get("unit", (field.metadata or {}).get(b"unit", b"").decode()))
        values = _numbers(table, field.name)[seen]
        found.append(Column(field.name, clock, values, unit, entry.get("source", ""), entry.get("note", "")))
    return found


def to_pandas(channels: Iterable[Column]) -> Any:
    """A pandas DataFrame over the time stamps of all channels [s]; units, sources and notes in its `attrs`."""
    pandas, signals = library("pandas"), list(channels)
    time, columns = _dense(signals)
    frame = pandas.DataFrame(columns, index=pandas.Index(time, name=TIME))
    frame.attrs[KEY] = _about(signals) | {"": {"sparse": any(len(each.time) < len(time) for each in signals)}}
    return frame


def from_pandas(
    frame: pandas.DataFrame, units: Mapping[str, str] | None = None, sparse: bool | None = None
) -> list[Column]:
    """The columns of a pandas DataFrame whose index, or column "time", is the time [s] or a calendar time.

    Args:
        frame: data frame of numbers; NaN is a missing sample
        units: units by column name; those that `to_pandas` stored where not given
        sparse: whether NaN means that there is no sample, as in joined channels of different rates; where not
            given, what `to_pandas` stored, else False
    """
    about = frame.attrs.get(KEY, {})
    sparse = about.get("", {}).get("sparse", False) if sparse is None else sparse
    frame = frame.set_index(TIME) if TIME in frame.columns else frame
    table = {str(name): np.asarray(frame[name], dtype=float) for name in frame.columns}
    return _columns(_seconds(np.asarray(frame.index)), table, about, units, sparse)


def to_polars(channels: Iterable[Column]) -> Any:
    """A Polars DataFrame with a column of time stamps [s]; Polars does not store units."""
    return library("polars").from_arrow(to_arrow(channels))


def to_xarray(channels: Iterable[Column]) -> Any:
    """An xarray Dataset over the coordinate "time" [s]; unit, source and note are attributes of every variable."""
    xarray, signals = library("xarray"), list(channels)
    time, columns = _dense(signals)
    about = _about(signals)
    variables = {name: (TIME, values, about[name]) for name, values in columns.items()}
    sparse = int(any(len(each.time) < len(time) for each in signals))
    return xarray.Dataset(variables, coords={TIME: (TIME, time, {"unit": "s"})}, attrs={"sparse": sparse})


def from_xarray(
    data: xarray.Dataset, units: Mapping[str, str] | None = None, sparse: bool | None = None
) -> list[Column]:
    """The variables of an xarray Dataset over the coordinate "time" [s]; arguments as for `from_pandas`."""
    about = {str(name): dict(variable.attrs) for name, variable in data.data_vars.items()}
    sparse = bool(data.attrs.get("sparse", False)) if sparse is None else sparse
    table = {str(name): np.asarray(variable, dtype=float) for name, variable in data.data_vars.items()}
    return _columns(_seconds(np.asarray(data[TIME])), table, about, units, sparse)


def _joined(signals: list[Column]) -> tuple[np.ndarray, list[np.ndarray]]:
    """All time stamps, and the indices of those of every signal among them.

    A stamp that a signal holds twice takes two rows, of which the first is shared with the other signals.
    """
    if any(each.name == TIME for each in signals):
        raise InputError(f"a channel is called '{TIME}', as the column of time stamps is; rename it")
    numbered = {id(each.time): _numbered(each.time) for each in signals}
    if not numbered:
        return np.empty(0), []
    every = np.unique(np.concatenate(list(numbered.values())), axis=0)
    keys = _keys(every)
    places = {clock: np.searchsorted(keys, _keys(rows)) for clock, rows in numbered.items()}
    return every[:, 0].copy(), [places[id(each.time)] for each in signals]


def _numbered(time: np.ndarray) -> np.ndarray:
    """Time stamps, each with its running number among equal ones, shape (n, 2)."""
    time = np.asarray(time, dtype=float)
    first = np.searchsorted(time, time, side="left")
    return np.stack([time, np.arange(len(time)) - first], axis=1)


def _keys(rows: np.ndarray) -> np.ndarray:
    return rows[:, 0] + 1j * rows[:, 1]


def _dense(signals: list[Column]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    time, places = _joined(signals)
    columns = {}
    for each, at in zip(signals, places, strict=True):
        columns[each.name] = np.full(len(time), np.nan)
        columns[each.name][at] = each.values
    return time, columns


def _columns(
    time: np.ndarray,
    table: Mapping[str, np.ndarray],
    about: Mapping[str, Mapping[str, str]],
    units: Mapping[str, str] | None,
    sparse: bool,
) -> list[Column]:
    found = []
    for name, values in table.items():
        seen = np.isfinite(values) if sparse else np.ones(len(values), dtype=bool)
        entry = about.get(name, {})
        unit = (units or {}).get(name, entry.get("unit", ""))
        stamps = time if seen.all() else time[seen]
        found.append(Column(name, stamps, values[seen], unit, entry.get("source", ""), entry.get("note", "")))
    return found


def _seconds(time: np.ndarray) -> np.ndarray:
    """Time stamps in seconds; calendar times count from the first."""
    if time.dtype.kind not in "mM":
        return time.astype(float)
    return np.asarray((time - time[:1]) / np.timedelta64(1, "s"), dtype=float)


def _about(signals: list[Column]) -> dict[str, Any]:
    return {each.name: {"unit": each.unit, "source": each.source, "note": each.note} for each in signals}


def _numbers(table: pa.Table, name: str) -> np.ndarray:
    import pyarrow as pa

    try:
        return floats(table[name])
    except pa.ArrowException:
        raise InputError(
            f"the column '{name}' is of the type {table.schema.field(name).type}; expected numbers"
        ) from None


_PER_SECOND = {"s": 1, "ms": 1_000, "us": 1_000_000, "ns": 1_000_000_000}


def native_file(path: Path, mode: Literal["rb", "wb"] = "rb") -> Any:
    """A file that Arrow reads or writes by itself, whatever its name.

    Args:
        path: path of the file; Arrow refuses names that are not UTF-8 as text, but not as bytes
    """
    import pyarrow as pa

    return pa.OSFile(os.fsencode(path), mode)


def is_number(kind: pa.DataType) -> bool:
    """Whether an Arrow type holds numbers, decimals or truth values, which `floats` reads."""
    import pyarrow.types as types

    tests = (types.is_integer, types.is_floating, types.is_boolean, types.is_decimal)
    return any(test(kind) for test in tests)


def floats(column: pa.Array | pa.ChunkedArray) -> np.ndarray:
    """A column of numbers, decimals or truth values as floats; nulls become NaN.

    Args:
        column: pyarrow Array or ChunkedArray, shape (n,)
    """
    import pyarrow as pa

    if pa.types.is_boolean(column.type):
        column = column.cast(pa.int8())
    if column.type != pa.float64():
        column = column.cast(pa.float64(), safe=False)
    parts = [
        np.where(_valid(chunk), _memory(chunk, np.float64), np.nan) if chunk.null_count else _memory(chunk, np.float64)
        for chunk in _chunks(column)
    ]
    return parts[0] if len(parts) == 1 else np.concatenate(parts or [np.empty(0)])


def calendar_seconds(column: pa.Array | pa.ChunkedArray) -> np.ndarray:
    """A column of calendar times in seconds since 1970; nulls become NaN."""
    import pyarrow as pa

    if not pa.types.is_timestamp(column.type):
        column = column.cast(pa.timestamp("ns"))
    per = _PER_SECOND[column.type.unit]
    parts = []
    for chunk in _chunks(column.cast(pa.int64())):
        ticks = _memory(chunk, np.int64)
        # Seconds and fraction are divided apart: nanoseconds since 1970 exceed the 53 bits of a float.
        parts.append(np.where(_valid(chunk), ticks // per + (ticks % per) / per, np.nan))
    return np.concatenate(parts or [np.empty(0)])


def _chunks(column: pa.Array | pa.ChunkedArray) -> list[pa.Array]:
    return column.chunks if hasattr(column, "chunks") else [column]


def _memory(chunk: pa.Array, kind: type[np.generic]) -> np.ndarray:
    values = chunk.buffers()[1]
    if values is None:
        return np.empty(0, dtype=kind)
    return np.frombuffer(values, dtype=kind)[chunk.offset : chunk.offset + len(chunk)]


def _valid(chunk: pa.Array) -> np.ndarray:
    bitmap = chunk.buffers()[0]
    if bitmap is None:
        return np.full(len(chunk), chunk.null_count == 0)
    bits = np.unpackbits(np.frombuffer(bitmap, dtype=np.uint8), bitorder="little")
    return bits[chunk.offset : chunk.offset + len(chunk)].astype(bool)


def column_of(values: np.ndarray, length: int | None = None) -> pa.Array:
    import pyarrow as pa

    dense = np.ascontiguousarray(values, dtype=np.float64)
    made = pa.Array.from_buffers(pa.float64(), len(dense), [None, pa.py_buffer(dense)])
    if length is None or length <= len(dense):
        return made
    return pa.concat_arrays([made, pa.nulls(length - len(dense), pa.float64())])
