"""Time stamps as recorders write them, and what is done about their faults.

Dropped, with a note: samples whose stamp is not a finite number; infinite values become missing (NaN).
Sorted, with a note: stamps that fall back by no more than `LATE`, since loggers deliver their buffers out of order.
Kept, with a note: equal stamps; the last of them counts when a recording is aligned.
Refused: a clock that jumps back further, or that stands still throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.errors import InputError

LATE = 0.5
"""A logger's buffers reorder samples by less than this [s]; a clock that was set back falls back by more."""

CALENDAR = 1.0e8
"""Stamps above this [s] (three years) count from a calendar date, not from the start of the recording."""


@dataclass(frozen=True)
class Order:
    """What makes time stamps usable.

    Args:
        time: [s], finite, not decreasing, shape (n,)
        index: the samples to take, in order; None where all are taken as they are
        notes: what was repaired
        behind: how late the latest of those came that were put in order [s]
    """

    time: np.ndarray
    index: np.ndarray | None
    notes: tuple[str, ...] = ()
    behind: float = 0.0

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """The values that belong to the stamps."""
        return values if self.index is None else values[self.index]


def order(time: np.ndarray, what: str) -> Order:
    """Time stamps made usable, or a refusal.

    Args:
        time: [s], as recorded, shape (n,)
        what: whose time it is, for the message

    Raises:
        InputError: no stamp is a number, the clock jumps back by more than LATE, or stands still throughout
    """
    time = np.asarray(time, dtype=float)
    index, notes, behind = None, [], 0.0
    finite = np.isfinite(time)
    if len(time) and not finite.all():
        index = np.flatnonzero(finite)
        if not len(index):
            raise InputError(f"no time stamp of {what} is a number; name the right time column, or export again")
        notes.append(f"{len(time) - len(index)} samples without a time stamp left out")
        time = time[index]
    steps = np.diff(time)
    if (steps < 0.0).any():
        behind = _behind(time, what)
        notes.append(f"{int((steps < 0.0).sum())} samples that arrived late put in order")
        sort = np.argsort(time, kind="stable")
        time, index = time[sort], sort if index is None else index[sort]
        steps = np.diff(time)
    equal = int((steps == 0.0).sum())
    if equal and equal == len(steps) and len(steps) > 1:
        raise InputError(
            f"the time of {what} stands still at {time[0]:g} s for all {len(time)} samples; "
            "name the right time column, or export again with the recorder's clock running"
        )
    if equal:
        longest, begin = _longest_run(steps == 0.0)
        notes.append(f"{equal} equal time stamps (the clock stands at {time[begin]:.6g} s for {longest + 1} samples)")
    return Order(time, index, tuple(notes), behind)


def _behind(time: np.ndarray, what: str) -> float:
    """How late the latest sample comes [s]; refused where the clock was set back."""
    behind = np.maximum.accumulate(time) - time
    if behind.max() <= LATE:
        return float(behind.max())
    at = int(np.flatnonzero(behind > LATE)[0])
    raise InputError(
        f"the time of {what} jumps back from {time[at - 1]:.6f} s to {time[at]:.6f} s at sample {at + 1}; "
        f"only {LATE} s of disorder can be sorted: cut the recording there and read the parts one by one"
    )


def _longest_run(flags: np.ndarray) -> tuple[int, int]:
    edges = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if not len(begins):
        return 0, 0
    at = int(np.argmax(ends - begins))
    return int(ends[at] - begins[at]), int(begins[at])


def longest_run(flags: np.ndarray) -> int:
    """The length of the longest run of true values."""
    return _longest_run(np.asarray(flags, dtype=bool))[0]


def finite_or_missing(values: np.ndarray) -> tuple[np.ndarray, str]:
    """The values as floats with infinities made missing (NaN), and the note on it ("" where there were none)."""
    values = np.asarray(values, dtype=float)
    infinite = np.isinf(values)
    count = int(np.count_nonzero(infinite))
    if not count:
        return values, ""
    return np.where(infinite, np.nan, values), f"{count} infinite values taken as missing"


def paced(time: np.ndarray, period: float, patience: float = 1.0) -> np.ndarray:
    """When samples were sent that were delivered in bursts.

    A sample is never delivered before it was sent, and sent one period after its predecessor: so the delay of each is
    what it came later than the promptest delivery within the next `patience` seconds. Lost samples stay gaps.

    Args:
        time: stamps of delivery [s], not decreasing, shape (n,)
        period: of the sender [s]
        patience: within this time [s] at least one sample is delivered promptly; also absorbs drift of the clocks

    Raises:
        InputError: a period that is not positive
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
