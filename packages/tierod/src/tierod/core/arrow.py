"""Conversion between NumPy arrays and Arrow columns through their memory; pyarrow's own conversions import pandas."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa

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
