"""Time stamps as recorders write them, and the repair of their faults.

Dropped, with a note: samples whose stamp is not a finite number; infinite values become missing (NaN).
Sorted, with a note: stamps that fall back by no more than `LATE`, since loggers deliver their buffers out of order.
Kept, with a note: equal stamps; the last of them counts when a recording is aligned.
Refused: a clock that jumps back further, or that stands still throughout.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tierod.core.errors import InputError
from tierod.core.series import runs

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
