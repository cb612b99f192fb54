"""Long time series in bounded memory: lowest, highest and mean value of every bin, so that no peak is lost.

A `Decimator` collects a trace at the resolution that its memory allows; `merged` and `coarser` reduce the resolution;
`pack` compresses a trace for a page or a store.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.findings import Trace

MEMORY = 2**20  # Number of bins of all traces of a recording together, 32 bytes each
OVERVIEW = 4000  # Number of points of a trace for an overview of the whole recording
FEW = 16  # Largest number of samples per bin for which all bins are processed together, one sample of each at a time

# Operations that merge lowest value, highest value, sum, and number of samples of two bins
MERGES = (np.minimum, np.maximum, np.add, np.add)

# Lowest value, highest value, sum, and number of samples of an empty bin
EMPTY = np.array([[np.inf], [-np.inf], [0.0], [0.0]])

MISSING = 0  # Code of a bin without a sample in a packed trace


def bins_each(traces: int) -> int:
    """Smallest number of bins of each trace once it is full: a power of two, 16 384 for 30 traces."""
    return 1 << max(MEMORY // (2 * max(traces, 1)), 1).bit_length() - 1


class Places(NamedTuple):
    # start of the first bin of the trace, and width of the bins [s]
    start: Annotated[float, "s"]
    width: Annotated[float, "s"]
    # bins of the first and of the last sample
    first: int
    last: int
    bins: np.ndarray  # bin of every sample, counted from `first`
    samples: np.ndarray  # number of samples in every bin from `first` to `last`
    occupied: np.ndarray | slice  # bins with at least one sample; a slice of all where none is empty
    begins: np.ndarray  # index of the first sample of each occupied bin
    # number of samples of every inner bin, which the first and the last bin do not exceed; 0 where the inner bins
    # differ or hold more than `FEW`
    even: int

    @classmethod
    def of(cls, time: np.ndarray, start: float, width: float) -> Places:
        """Bins of increasing times [s], shape (n,), at least one."""
        # Rounding may put a time at the edge of a bin just below it.
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
            values: values of the samples, (n,), none missing
        """
        if not self.even:
            lower, upper = (edge.reduceat(values, self.begins) for edge in (np.minimum, np.maximum))
            return lower, upper, np.bincount(self.bins, values, len(self.samples))
        # Column by column: `reduceat` costs more per bin than a few samples do. The ends are filled up with neutral
        # values: neighbours for the extremes, zeros for the sum.
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
        bins: smallest number of bins once the memory is full; the largest is twice that
    """

    def __init__(self, name: str, unit: str, bins: int = 2000, reserved: bool = False):
        self.name, self.unit, self.bins = name, unit, bins
        self._start: float | None = None
        self._width = 0.0
        self._size = 0
        # A page of memory is taken only when it is written. By rounding, the last bin may lie at the very end.
        self._lower, self._upper, self._sum, self._count = self._all = np.empty((4, 2 * bins + 2))
        if reserved:
            self._clear(slice(None))

    def add(self, time: np.ndarray, values: np.ndarray, places: Places | None = None) -> Places | None:
        """Add samples that follow those already added.

        Args:
            time: [s], shape (n,), increasing
            values: shape (n,); NaN where missing

        Returns:
            bins of the samples, for the next signal with the same times; None without samples
        """
        if not len(time):
            return None
        if self._start is None:
            self._start = float(time[0])
            # The first bins hold one sample each: their width is the usual sampling interval.
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
        """Add samples of which none is missing, so that each bin holds a contiguous stretch of them."""
        at = places.occupied
        lower, upper = self._lower[touched], self._upper[touched]
        least, most, total = places.merged(values)
        lower[at] = np.minimum(lower[at], least)
        upper[at] = np.maximum(upper[at], most)
        self._sum[touched] += total
        self._count[touched] += places.samples

    def _put_some(self, touched: slice, index: np.ndarray, values: np.ndarray) -> None:
        # Only the bins of these samples: with many bins and short chunks, passing over all bins would dominate.
        np.minimum.at(self._lower[touched], index, values)
        np.maximum.at(self._upper[touched], index, values)
        width = touched.stop - touched.start
        self._sum[touched] += np.bincount(index, values, width)
        self._count[touched] += np.bincount(index, minlength=width)

    def trace(self) -> Trace:
        """Trace collected so far; NaN where a bin holds no sample."""
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
    """The trace with `step` neighbouring bins merged; the extremes are kept, and the mean weights all bins alike."""
    if step <= 1:
        return trace
    lower, upper = extremes(np.asarray(trace.lower, float), np.asarray(trace.upper, float), step)
    mean = np.asarray(trace.mean, float)
    begins = np.arange(0, len(mean), step)
    seen = np.isfinite(mean)
    count = np.add.reduceat(seen, begins, dtype=int) if len(begins) else begins
    total = np.add.reduceat(np.where(seen, mean, 0.0), begins) if len(begins) else mean
    mean = np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0)
    return Trace(trace.name, trace.unit, np.asarray(trace.time)[::step], lower, upper, mean)


def extremes(lower: np.ndarray, upper: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Minima and maxima of groups of neighbours; NaN where all are missing. The last group may be smaller."""
    whole = len(lower) - len(lower) % step

    def merged_by(of: np.ufunc, values: np.ndarray) -> np.ndarray:
        rows = values[:whole].reshape(-1, step)
        # Reducing along short rows, NumPy is ten times as slow as over whole columns.
        found = of.reduce(rows, axis=1) if step > FEW else reduce(of, rows.T)
        return np.append(found, of.reduce(values[whole:])) if whole < len(values) else np.asarray(found)

    return merged_by(np.fmin, lower), merged_by(np.fmax, upper)


def merged(trace: Trace, points: int = OVERVIEW) -> Trace:
    """The trace with neighbouring bins merged until there are few enough; the extremes are kept."""
    return coarser(trace, -(-len(trace.time) // points))


@dataclass(frozen=True)
class Packed:
    """A trace quantised to integer codes and compressed."""

    # name and unit of the trace
    name: str
    unit: str
    start: Annotated[float, "s"]  # left edge of the first bin [s]
    width: Annotated[float, "s"]  # width of a bin [s]
    count: int  # number of bins
    lowest: float  # value of the code 1 [unit]
    step: float  # difference between neighbouring codes [unit]
    # codes of every bin as 16-bit numbers: change of the mean in zigzag, highest less mean, mean less lowest; all
    # low bytes, then all high bytes; zlib
    data: bytes


def outline(values: np.ndarray, most: int) -> np.ndarray:
    """Indices of the samples that outline a curve: extremes of every bin, first and last one, and begins of gaps.

    Args:
        values: shape (n,); NaN breaks the curve

    Returns:
        increasing indices; those of all samples where there are no more than `most`
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
    """The trace quantised and compressed; None where its bins differ in width."""
    time = np.asarray(trace.time, float)
    width, count = bin_width(trace), len(time)
    start = float(time[0]) if count else 0.0
    if count > 1 and not np.all(np.abs(time - start - width * np.arange(count)) < 0.01 * width):
        return None
    lower, upper, mean = (np.asarray(part, float) for part in (trace.lower, trace.upper, trace.mean))
    seen = np.isfinite(mean)
    low, high = (float(np.min(lower[seen])), float(np.max(upper[seen]))) if seen.any() else (0.0, 0.0)
    most = 2**bits - 1
    # A range within rounding of a constant counts as none; dividing each end by itself keeps the widest range finite.
    step = max(high / (most - 1) - low / (most - 1), 1e-12 * max(abs(low), abs(high))) or 1.0

    def code(values: np.ndarray) -> np.ndarray:
        known = np.where(seen, values, low)
        return np.where(seen, np.clip(np.round(known / step - low / step) + 1.0, 1, most), MISSING).astype(int)

    least, middle, greatest = code(lower), code(mean), code(upper)
    middle = np.clip(middle, least, greatest)
    # Differences modulo 2**16 fit into 16 bits; the reader sums them modulo 2**16 again.
    change = (np.diff(middle, prepend=0) + 2**15) % 2**16 - 2**15
    numbers = np.concatenate([(change << 1) ^ (change >> 15), greatest - middle, middle - least]).astype("<u2")
    data = zlib.compress(numbers.view(np.uint8).reshape(-1, 2).T.tobytes(), 6)
    return Packed(trace.name, trace.unit, start, width, count, low, step, data)
