"""Long time series in bounded memory: lowest, highest and mean value of every bin, so that nothing is hidden.

A `Decimator` makes a trace, as fine as memory allows; `merged` and `coarser` make levels of it for less room; `pack`
makes a level small enough for a page or a store, and `unpack` a trace again.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Trace

MEMORY = 2**20
"""Bins of all traces of a recording together, 32 bytes each."""

OVERVIEW = 4000
"""Points of a trace that are enough to see all of it at once."""

FEW = 16
"""Samples of a bin up to which all bins are gone through together, sample by sample."""

MERGES = (np.minimum, np.maximum, np.add, np.add)
"""How lowest and highest value, sum, and number of samples of two bins become those of both."""

EMPTY = np.array([[np.inf], [-np.inf], [0.0], [0.0]])
"""Lowest and highest value, sum, and number of samples of a bin without any."""

MISSING = 0
"""Code of a bin without a sample in a packed trace."""


def bins_each(traces: int) -> int:
    """Bins of one of so many traces, at the least once they are full: a power of two, 16 384 for 30 traces."""
    return 1 << max(MEMORY // (2 * max(traces, 1)), 1).bit_length() - 1


class Places(NamedTuple):
    """In which bins samples lie.

    Args:
        start, width: of the bins [s]
        first, last: bins of the samples
        bins: that of every sample, counted from the first
        samples: number of those in every bin from first to last
        occupied: those bins that have one, all as a slice where none is empty
        begins: first sample of each of these
        even: samples of every bin but the first and the last, which have no more; 0 where they differ or are many
    """

    start: Annotated[float, "s"]
    width: Annotated[float, "s"]
    first: int
    last: int
    bins: np.ndarray
    samples: np.ndarray
    occupied: np.ndarray | slice
    begins: np.ndarray
    even: int

    @classmethod
    def of(cls, time: np.ndarray, start: float, width: float) -> Places:
        """Places of rising times [s], shape (n,), at least one."""
        bins = np.floor((time - start) / width + 1e-6).astype(int)
        first, last = int(bins[0]), int(bins[-1])
        bins -= first
        counts = np.bincount(bins, minlength=last - first + 1)
        occupied: np.ndarray | slice = slice(None)
        begins = np.cumsum(counts) - counts
        if not counts.all():
            occupied = np.flatnonzero(counts)
            begins = begins[occupied]
        inner = int(counts[1]) if len(counts) > 2 else 0
        even = inner <= FEW and bool((counts[1:-1] == inner).all()) and max(counts[0], counts[-1]) <= inner
        return cls(start, width, first, last, bins, counts, occupied, begins, inner if even else 0)

    def merged(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Lowest and highest value of every occupied bin, and the sum in every bin.

        Args:
            values: of the samples, (n,), none missing
        """
        if not self.even:
            lower, upper = (edge.reduceat(values, self.begins) for edge in (np.minimum, np.maximum))
            return lower, upper, np.bincount(self.bins, values, len(self.samples))
        # Column by column: a bin of its own for every few samples costs more than they do.
        before = self.even - int(self.samples[0])
        rows = np.empty((len(self.samples), self.even))
        flat, after = rows.reshape(-1), before + len(values)
        flat[:before], flat[before:after], flat[after:] = values[0], values, values[-1]
        lower, upper = rows[:, 0].copy(), rows[:, 0].copy()
        for column in rows.T[1:]:
            np.minimum(lower, column, out=lower)
            np.maximum(upper, column, out=upper)
        flat[:before] = flat[after:] = 0.0
        total = np.zeros(len(rows))
        for column in rows.T:
            total += column
        return lower, upper, total


class Decimator:
    """Collects one signal chunk by chunk; bins double in width as the recording grows.

    Args:
        name: of the signal
        unit: in the notation of pint
        bins: least number of bins once they are full; at the most twice as many
        reserved: whether memory for all of them is taken at once, so that a program that runs for long keeps its size
    """

    def __init__(self, name: str, unit: str, bins: int = 2000, reserved: bool = False):
        self.name, self.unit, self.bins = name, unit, bins
        self._start: float | None = None
        self._width = 0.0
        self._size = 0
        # The system gives a page only when something is written to it. The last bin may lie at the end by rounding.
        self._lower, self._upper, self._sum, self._count = self._all = np.empty((4, 2 * bins + 2))
        if reserved:
            self._clear(slice(None))

    def add(self, time: np.ndarray, values: np.ndarray, places: Places | None = None) -> Places | None:
        """Samples that follow those already added.

        Args:
            time: [s], shape (n,), rising
            values: shape (n,); NaN where missing
            places: places by another signal's decimator for the same times

        Returns:
            where the samples lie, for the next signal with the same times; None without samples
        """
        if not len(time):
            return None
        if self._start is None:
            self._start = float(time[0])
            steps = np.diff(time[:1000])
            steps = steps[steps > 0.0]
            self._width = float(np.median(steps)) if len(steps) else 1.0
        while (time[-1] - self._start) / self._width >= 2 * self.bins:
            self._halve()
        if places is None or (places.start, places.width) != (self._start, self._width):
            places = Places.of(time, self._start, self._width)
        self._grow(places.last + 1)
        touched = slice(places.first, places.last + 1)
        seen = np.isfinite(values)
        if seen.all():
            self._put(touched, places, values)
        else:
            self._put_some(touched, places.bins[seen], values[seen])
        return places

    def _put(self, touched: slice, places: Places, values: np.ndarray) -> None:
        """Samples of which none is missing: neighbours share a bin, so that each bin is a stretch of them."""
        at = places.occupied
        lower, upper = self._lower[touched], self._upper[touched]
        least, most, total = places.merged(values)
        lower[at] = np.minimum(lower[at], least)
        upper[at] = np.maximum(upper[at], most)
        self._sum[touched] += total
        self._count[touched] += places.samples

    def _put_some(self, touched: slice, index: np.ndarray, values: np.ndarray) -> None:
        # Only the bins of these samples: with many bins, and few samples at a time, all others would cost most.
        np.minimum.at(self._lower[touched], index, values)
        np.maximum.at(self._upper[touched], index, values)
        width = touched.stop - touched.start
        self._sum[touched] += np.bincount(index, values, width)
        self._count[touched] += np.bincount(index, minlength=width)

    def trace(self) -> Trace:
        """Collected trace; NaN where a bin holds no sample."""
        used = slice(self._size)
        count = self._count[used]
        seen = count > 0
        mean = np.divide(self._sum[used], count, out=np.full(len(seen), np.nan), where=seen)
        time = (self._start or 0.0) + self._width * np.arange(len(seen))
        lower, upper = (np.where(seen, edge[used], np.nan) for edge in (self._lower, self._upper))
        return Trace(self.name, self.unit, time, lower, upper, mean)

    def _grow(self, size: int) -> None:
        if size > self._size:
            self._clear(slice(self._size, size))
            self._size = size

    def _clear(self, part: slice) -> None:
        self._all[:, part] = EMPTY

    def _halve(self) -> None:
        self._grow(self._size + self._size % 2)
        half = self._size // 2
        even, odd = self._all[:, : self._size : 2], self._all[:, 1 : self._size : 2]
        for bins, first, second, merge in zip(self._all, even, odd, MERGES, strict=True):
            merge(first, second, out=bins[:half])
        self._size = half
        self._width *= 2.0


def coarser(trace: Trace, step: int) -> Trace:
    """The trace with neighbouring bins merged; the extremes stay.

    Args:
        trace: at any resolution
        step: bins that become one
    """
    if step <= 1:
        return trace
    pad = -len(trace.time) % step
    lower, upper, mean = (
        np.pad(np.asarray(part, float), (0, pad), constant_values=np.nan).reshape(-1, step)
        for part in (trace.lower, trace.upper, trace.mean)
    )
    seen = np.isfinite(mean)
    count = seen.sum(axis=1)
    none = count == 0
    total = np.where(seen, mean, 0.0).sum(axis=1)
    return Trace(
        trace.name,
        trace.unit,
        np.asarray(trace.time)[::step],
        np.where(none, np.nan, np.where(seen, lower, np.inf).min(axis=1)),
        np.where(none, np.nan, np.where(seen, upper, -np.inf).max(axis=1)),
        np.divide(total, count, out=np.full(len(count), np.nan), where=~none),
    )


def merged(trace: Trace, points: int = OVERVIEW) -> Trace:
    """The trace with neighbouring bins merged until there are few enough; the extremes stay.

    Args:
        trace: at any resolution
        points: most bins that are left
    """
    return coarser(trace, -(-len(trace.time) // points))


@dataclass(frozen=True)
class Packed:
    """A trace in whole numbers, compressed.

    Args:
        name, unit: of the trace
        start: left edge of the first bin [s]
        width: of a bin [s]
        count: of the bins
        lowest: value of the code 1 [unit]
        step: value from one code to the next [unit]
        data: mean, highest less mean, and mean less lowest code of every bin, the mean as its change, in zigzag; of all
            numbers the low bytes, then the high ones; zlib
    """

    name: str
    unit: str
    start: Annotated[float, "s"]
    width: Annotated[float, "s"]
    count: int
    lowest: float
    step: float
    data: bytes


def outline(values: np.ndarray, most: int) -> np.ndarray:
    """Numbers of the samples that outline a curve: lowest and highest of every bin, first, last, and where gaps begin.

    Args:
        values: shape (n,); NaN breaks the curve
        most: samples that are wanted at the most, but for gaps

    Returns:
        rising; all of them where there are not more
    """
    count, bins = len(values), max(most // 2 - 1, 1)
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, bins + 1).astype(int)
    missing = ~np.isfinite(values)
    values = np.where(missing, np.nan, values)
    chosen = [np.array([0, count - 1]), np.flatnonzero(missing & ~np.append(False, missing[:-1]))]
    for begin, end in pairwise(edges):
        part = values[begin:end]
        if not missing[begin:end].all():
            chosen.append(begin + np.array([np.nanargmin(part), np.nanargmax(part)]))
    return np.unique(np.concatenate(chosen))


def bin_width(trace: Trace) -> float:
    """Width of the bins [s]; 0 where there are fewer than two."""
    time = np.asarray(trace.time, float)
    return float(time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else 0.0


def pack(trace: Trace, bits: int = 16) -> Packed | None:
    """The trace packed; None where its bins differ in width.

    Args:
        trace: as `Decimator` or `coarser` gives it
        bits: of a code, 2 to 16: values are rounded to the range of the trace over 2**bits
    """
    time = np.asarray(trace.time, float)
    width, count = bin_width(trace), len(time)
    start = float(time[0]) if count else 0.0
    if count > 1 and not np.all(np.abs(time - start - width * np.arange(count)) < 0.01 * width):
        return None
    lower, upper, mean = (np.asarray(part, float) for part in (trace.lower, trace.upper, trace.mean))
    seen = np.isfinite(mean)
    low, high = (float(np.min(lower[seen])), float(np.max(upper[seen]))) if seen.any() else (0.0, 0.0)
    most = 2**bits - 1
    # A range that rounding makes of one value is none; halves keep the widest range finite.
    step = max(high / (most - 1) - low / (most - 1), 1e-12 * max(abs(low), abs(high))) or 1.0

    def code(values: np.ndarray) -> np.ndarray:
        known = np.where(seen, values, low)
        return np.where(seen, np.clip(np.round(known / step - low / step) + 1.0, 1, most), MISSING).astype(int)

    least, middle, greatest = code(lower), code(mean), code(upper)
    middle = np.clip(middle, least, greatest)
    change = (np.diff(middle, prepend=0) + 2**15) % 2**16 - 2**15
    numbers = np.concatenate([(change << 1) ^ (change >> 15), greatest - middle, middle - least]).astype("<u2")
    data = zlib.compress(numbers.view(np.uint8).reshape(-1, 2).T.tobytes(), 6)
    return Packed(trace.name, trace.unit, start, width, count, low, step, data)


def unpack(packed: Packed) -> Trace:
    """The trace that was packed, its values rounded to the steps of the codes."""
    places = np.frombuffer(zlib.decompress(packed.data), np.uint8).astype(int)
    low, high = places.reshape(2, -1)
    turned, above, below = (low + 256 * high).reshape(3, -1)
    middle = np.cumsum((turned >> 1) ^ -(turned & 1)) % 2**16
    lower, upper, mean = (
        np.where(middle == MISSING, np.nan, packed.lowest + packed.step * (codes - 1.0))
        for codes in (middle - below, middle + above, middle)
    )
    return Trace(packed.name, packed.unit, packed.start + packed.width * np.arange(packed.count), lower, upper, mean)
