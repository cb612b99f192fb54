"""Helpers for sampled series: runs of true values, decimation across pieces, and a growing table of rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError


def runs(flags: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First index, and one past the last index, of every run of true values, in order.

    Args:
        flags: (n,)
    """
    edges = np.flatnonzero(np.diff(np.asarray(flags, dtype=bool), prepend=False, append=False))
    return edges[::2], edges[1::2]


def longest_run(flags: np.ndarray) -> int:
    """The length of the longest run of true values; 0 where there is none.

    Args:
        flags: (n,)
    """
    begins, ends = runs(flags)
    return int((ends - begins).max(initial=0))


def last_true(flags: np.ndarray) -> int | None:
    """Index of the last true value; None where there is none.

    Args:
        flags: (n,)
    """
    at = len(flags) - 1 - int(np.argmax(flags[::-1])) if len(flags) else 0
    return at if len(flags) and flags[at] else None


class LastRead:
    """Last reading of each signal across consecutive pieces, since slow buses do not bring it with every sample.

    Args:
        fresh: longest time for which a reading holds [s]
    """

    def __init__(self, columns: int, fresh: float):
        self._fresh = fresh
        self._values, self._times = np.full((1, columns), np.nan), np.full((1, columns), -np.inf)

    def held(self, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Last reading at each sample of the next piece, (n, columns); NaN where it is older than `fresh`.

        Args:
            time: time stamps [s], (n,)
            values: readings, (n, columns); NaN where there is none
        """
        values = np.vstack((self._values, values))
        times = np.vstack((self._times, np.repeat(time[:, None], values.shape[1], axis=1)))
        place = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values))[:, None], 0), axis=0)
        held, read = (np.take_along_axis(each, place, axis=0) for each in (values, times))
        self._values, self._times = held[-1:], read[-1:]
        return np.where(times[1:] - read[1:] <= self._fresh, held[1:], np.nan)


class Stride:
    """Decimation across consecutive pieces: the first sample of all, then every `step`-th one."""

    def __init__(self, step: int):
        self.step = step
        self._seen = 0

    def over(self, count: int) -> slice:
        """Slice of the samples to take from the next piece."""
        first = -self._seen % self.step
        self._seen += count
        return slice(first, None, self.step)

    def indices(self, count: int) -> np.ndarray:
        """Indices of the samples to take from the next piece, in place of `over`."""
        return np.arange(count)[self.over(count)]


class Rows:
    """Growing table of rows of numbers, in one array that doubles when it is full.

    A list of slices would keep the whole arrays that they were cut from, and cost an object per slice.

    Args:
        most: largest number of rows; further ones are dropped; None keeps all
    """

    def __init__(self, columns: int, most: int | None = None):
        self._most, self._count = most, 0
        self._values = np.empty((0, columns))

    def __len__(self) -> int:
        return self._count

    @property
    def full(self) -> bool:
        """Whether further rows are dropped."""
        return self._most is not None and self._count >= self._most

    @property
    def values(self) -> np.ndarray:
        """All rows, (n, columns); valid until more are added."""
        return self._values[: self._count]

    def add(self, rows: np.ndarray) -> None:
        """Append rows, (n, columns)."""
        rows = rows if self._most is None else rows[: max(self._most - self._count, 0)]
        needed = self._count + len(rows)
        if needed > len(self._values):
            larger = np.empty((max(needed, 2 * len(self._values)), self._values.shape[1]))
            larger[: self._count] = self.values
            self._values = larger
        self._values[self._count : needed] = rows
        self._count = needed


LATE = 0.5  # Limit of the disorder that buffers of a logger cause [s]; a clock that was set back jumps by more
CALENDAR = 1.0e8  # Stamps above this [s] (three years) count from a calendar date, not from the start of the recording


@dataclass(frozen=True)
class Order:
    """Selection and order of the samples with usable time stamps."""

    time: np.ndarray  # [s], finite, not decreasing, shape (n,)
    index: np.ndarray | None  # indices of the samples to take, in order; None where all are taken as they are
    notes: tuple[str, ...] = ()
    behind: float = 0.0  # largest delay of the samples that were sorted [s]

    def __call__(self, values: np.ndarray) -> np.ndarray:
        return values if self.index is None else values[self.index]


class Repairs:
    """Counts the defects of the time stamps of one clock stretch by stretch; refuses those that cannot be repaired.

    `in_order` states whether the stamps of the latest stretch do not decrease and do not fall behind earlier ones.
    """

    def __init__(self, what: str):
        self.what = what
        self.behind = 0.0
        self._seen = self._without = self._late = self._equal = self._settled = 0
        self._newest = self._last = -np.inf
        self._final = np.nan
        self._run = self._longest = 1
        self._stands_at = np.nan
        self.in_order = True

    @property
    def newest(self) -> float:
        """The latest stamp so far [s]; minus infinity before the first."""
        return self._newest

    def arrived(self, time: np.ndarray) -> np.ndarray | None:
        """Check the next stamps and return the mask of those that are numbers; None where all are.

        Args:
            time: [s], as recorded, shape (n,)
        """
        self.in_order = _follow(time, self._newest)
        if self.in_order and math.isfinite(time[0]) and math.isfinite(time[-1]):
            # The usual case: stamps in order between two finite ones are themselves finite and not late.
            self._seen, self._newest, self._last = self._seen + len(time), float(time[-1]), float(time[-1])
            return None
        finite = np.isfinite(time)
        kept = None if finite.all() else finite
        if kept is not None:
            self._without += len(time) - int(np.count_nonzero(finite))
            time = time[finite]
        if len(time):
            self.in_order = _follow(time, self._newest)
            before = np.concatenate(([self._last], time[:-1]))
            self._late += int(np.count_nonzero(time < before))
            newest = np.maximum(np.maximum.accumulate(time), self._newest)
            with np.errstate(over="ignore"):
                behind = newest - time
            if behind.max() > LATE:
                at = int(np.flatnonzero(behind > LATE)[0])
                raise InputError(
                    f"the time of {self.what} jumps back from {_stamp(before[at])} to {_stamp(time[at])} at sample "
                    f"{self._seen + at + 1}; only {LATE} s of disorder can be sorted: cut the recording there and read "
                    "the parts one by one; if a counter rolled over, export it with continuous values"
                )
            self.behind = max(self.behind, float(behind.max()))
            self._seen, self._newest, self._last = self._seen + len(time), float(newest[-1]), float(time[-1])
        return kept

    def settled(self, time: np.ndarray) -> None:
        """Count the equal ones among the next stamps in their final order [s], shape (n,)."""
        if not len(time):
            return
        same = np.concatenate(([time[0] == self._final], time[1:] == time[:-1]))
        equal = int(np.count_nonzero(same))
        if equal:
            self._equal += equal
            begins, ends = runs(same)
            # A run at the very beginning continues that of the last stretch; any other lacks its first stamp.
            lengths = ends - begins + np.where(begins == 0, self._run, 1)
            if lengths.max() > self._longest:
                at = int(np.argmax(lengths))
                self._longest, self._stands_at = int(lengths[at]), float(time[begins[at]])
        self._run = self._run + equal if equal == len(time) else int(np.argmin(same[::-1])) + 1
        self._final = float(time[-1])
        self._settled += len(time)

    def refuse_unusable(self) -> None:
        """Refuse a clock without usable stamps; called after the last stretch."""
        if self._without and not self._seen:
            raise InputError(f"no time stamp of {self.what} is a number; name the right time column, or export again")
        if self._settled > 2 and self._equal == self._settled - 1:
            raise InputError(
                f"the time of {self.what} stands still at {self._final:g} s for all {self._settled} samples; "
                "name the right time column, or export again with the recorder's clock running"
            )

    @property
    def notes(self) -> tuple[str, ...]:
        stands = f"(the clock stands at {self._stands_at:.6g} s for {self._longest} samples)"
        found = (
            (self._without, "samples without a time stamp left out"),
            (self._late, "samples that arrived late put in order"),
            (self._equal, f"equal time stamps {stands}"),
        )
        return tuple(f"{count} {text}" for count, text in found if count)


def _follow(time: np.ndarray, newest: float) -> bool:
    """Whether there are stamps [s], in order and not behind the newest one before [s]; False with a NaN."""
    return bool(len(time) and time[0] >= newest and (time[1:] >= time[:-1]).all())


def _stamp(time: float) -> str:
    """A time stamp [s] to the microsecond; with six significant digits where it is too large for one."""
    return f"{time:.6f} s" if abs(time) < 1e11 else f"{time:.6g} s"


def order(time: np.ndarray, what: str) -> Order:
    """Order of the usable samples, from the recorded time stamps.

    Args:
        time: [s], as recorded, shape (n,)
    """
    time = np.asarray(time, dtype=float)
    repairs = Repairs(what)
    finite = repairs.arrived(time)
    index = None if finite is None else np.flatnonzero(finite)
    time = time if index is None else time[index]
    if repairs.behind > 0.0:
        sort = np.argsort(time, kind="stable")
        time, index = time[sort], sort if index is None else index[sort]
    repairs.settled(time)
    repairs.refuse_unusable()
    return Order(time, index, repairs.notes, repairs.behind)


def finite_or_missing(values: np.ndarray) -> tuple[np.ndarray, int]:
    """The values as floats with infinities replaced by NaN (missing), and the number of infinities."""
    values = np.asarray(values, dtype=float)
    # A finite sum proves that all values are finite, without a mask.
    with np.errstate(over="ignore", invalid="ignore"):
        if math.isfinite(values.sum()):
            return values, 0
    infinite = np.isinf(values)
    count = int(np.count_nonzero(infinite))
    return (np.where(infinite, np.nan, values) if count else values), count


def infinite_note(count: int) -> str:
    """The note on infinite values; "" where there were none."""
    return f"{count} infinite values taken as missing" if count else ""


def paced(time: np.ndarray, period: float, patience: float = 1.0) -> np.ndarray:
    """Sending times of samples that were delivered in bursts.

    A sample is never delivered before it was sent, and is sent one period after its predecessor. Its delay is therefore
    its lateness against the promptest delivery within the next `patience` seconds. Lost samples stay gaps.

    Args:
        time: stamps of delivery [s], not decreasing, shape (n,)
        period: sampling interval of the sender [s]
        patience: time [s] within which at least one sample is delivered promptly; also absorbs drift of the clocks
    """
    if not period > 0.0:
        raise InputError(f"new time stamps need a positive period, not {period} s")
    if not len(time):
        return time
    number = np.arange(len(time)) * period
    width = max(int(patience / period), 1)
    offset = np.concatenate((time - number, np.full(width, np.inf)))
    prompt = np.lib.stride_tricks.sliding_window_view(offset, width + 1)[: len(time)].min(axis=1)
    return np.maximum.accumulate(number + prompt)
