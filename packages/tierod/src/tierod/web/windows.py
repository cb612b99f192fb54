"""Time spans of signals for pictures, as numbers in one packet; exports."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.web.errors import TooLarge
from tierod.web.pyramid import SeriesReader, Window

MOST_NAMES = 64
"""Largest number of signals in one picture."""

MOST_POINTS = 10_000
"""Largest number of points in a picture."""

MOST_EXPORTED = 20_000_000
"""Largest number of samples of an export, over all signals."""


def windows(
    readers: Sequence[SeriesReader], names: Sequence[str], start: float | None, stop: float | None, points: int
) -> list[tuple[str, Window]]:
    """(name, time span) of some signals."""
    if not 1 <= len(names) <= MOST_NAMES:
        raise InputError(f"{len(names)} signals are asked for; give 1 to {MOST_NAMES}")
    if not 10 <= points <= MOST_POINTS:
        raise InputError(f"{points} points are asked for; give 10 to {MOST_POINTS}")
    begin, end = _stretch(readers[0], start, stop)
    return [(name, _holding(readers, name).window(name, begin, end, points)) for name in names]


def _stretch(reader: SeriesReader, start: float | None, stop: float | None) -> tuple[float, float]:
    first, last = reader.span
    begin, end = first if start is None else start, last if stop is None else stop
    if not (np.isfinite([begin, end]).all() and begin <= end):
        raise InputError(f"a stretch from {begin:g} to {end:g} s is empty; give a begin before its end")
    return begin, end


def _holding(readers: Sequence[SeriesReader], name: str) -> SeriesReader:
    return next((each for each in readers if name in each.signals), readers[0])


def packet(found: Sequence[tuple[str, Window]]) -> bytes:
    """Time spans in one packet: length of the header, the header as JSON, then numbers, little-endian.

    The header states for every signal its count and whether every sample is included. Numbers are the time stamps as
    float64, then minima and, if not every sample is included, maxima as float32.
    """
    head = [{"name": name, "count": len(each.time), "exact": each.exact} for name, each in found]
    text = json.dumps(head).encode()
    # Padded to eight bytes, the alignment that the typed arrays of the browser require.
    text += b" " * (-(4 + len(text)) % 8)
    parts = [struct.pack("<I", len(text)), text]
    for _, each in found:
        parts.append(np.ascontiguousarray(each.time, "<f8").tobytes())
        values = [each.lower] if each.exact else [each.lower, each.upper]
        with np.errstate(over="ignore"):
            content = b"".join(np.ascontiguousarray(one, "<f4").tobytes() for one in values)
        parts.append(content + b"\0" * (-len(content) % 8))
    return b"".join(parts)


def export(
    readers: Sequence[SeriesReader], names: Sequence[str], start: float | None, stop: float | None, path: Path
) -> None:
    """Write every sample of some signals over a time span; further arguments and errors as in `windows`."""
    from tierod.io.writers import write

    # The end is included: `recording` excludes its upper limit.
    begin, end = _stretch(readers[0], start, stop)
    parts = [_holding(readers, name).recording([name], begin, np.nextafter(end, np.inf)) for name in names]
    whole = Recording({name: each[name] for name, each in zip(names, parts, strict=True)}, parts[0].metadata)
    if "path" in whole.metadata:  # an export must not reveal paths on the server
        whole = replace(whole, metadata={**whole.metadata, "path": Path(str(whole.metadata["path"])).name})
    count = sum(len(each.time) for each in whole.channels.values())
    if count > MOST_EXPORTED:
        raise TooLarge(f"{count} samples are more than {MOST_EXPORTED} at once; zoom in, or choose fewer signals")
    if not count:
        raise InputError("there are no samples in this stretch; choose another")
    write(whole, path)
