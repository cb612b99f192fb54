"""The grid that calibrations look at drives on, and when the vehicle moves on it."""

from __future__ import annotations

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Aligned, Recording
from tierod.monitors.condition.signals import WHEELS, ConditionSample

RATE = 100.0
"""Of the grid [Hz]; filters and limits are those of its steps."""
SLOWEST = 10.0
"""Rate of wheel speeds below which a recording is refused, as the monitor does [Hz]."""
MAXIMUM_AGE = 0.0099
"""A reading older than this is missing: every one counts in one sample, also of buses that do not keep step [s]."""
HELD = 0.5
"""For so long a wheel goes on as it was last read: its readings come more seldom than the grid's steps, or fail [s]."""
MOVING = 1.0
"""Speed of a wheel from which on the vehicle moves [m/s]."""


def sampled(recording: Recording, rate: float = RATE) -> Aligned:
    """The samples of a recording as the monitor takes them in.

    Args:
        recording: with signals of `ConditionSample`; what is missing is NaN
        rate: of the samples [Hz]
    """
    return recording.align(ConditionSample._fields, rate, maximum_age=MAXIMUM_AGE)


def aligned(recording: Recording, rate: float = RATE) -> np.ndarray:
    """The samples of a recording, one row each.

    Args:
        recording: with the signals of `ConditionSample`; what is missing is NaN
        rate: of the rows [Hz]
    """
    return sampled(recording, rate).values


def moving(rows: np.ndarray, rate: float = RATE) -> np.ndarray:
    """Whether the vehicle moves, forwards or backwards, by the wheels that are read, (n,).

    Args:
        rows: wheel speeds in the first two columns; NaN where missing, (n, 2 or more)
        rate: of the rows [Hz]
    """
    place, found = np.arange(len(rows)), np.zeros(len(rows), bool)
    for speed in rows[:, : len(WHEELS)].T:
        last = np.maximum.accumulate(np.where(np.isfinite(speed), place, -1))
        fresh = (last >= 0) & (place - last <= HELD * rate)
        found |= fresh & (np.abs(speed[np.maximum(last, 0)]) > MOVING)
    return found


def wheel_of(name: str, recording: Recording) -> str:
    """The rear wheel whose speed a recording holds, the left one if it holds both.

    Args:
        name: of the recording, for the message
        recording: to be looked at

    Raises:
        InputError: it holds neither, or brings it too slowly
    """
    there = [each for each in WHEELS if each in recording and len(recording[each].time)]
    if not there:
        raise InputError(
            f"{name} has neither {WHEELS[0]} nor {WHEELS[1]}: without one of them nothing is known of the drive; "
            "'tierod inspect' shows what it has"
        )
    time = recording[there[0]].time
    rate = 1.0 / float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if rate < 0.99 * SLOWEST:
        raise InputError(
            f"{name} brings {there[0]} at {rate:.3g} Hz; calibration needs {SLOWEST:g} Hz, better the "
            f"{RATE:g} Hz of the monitor: record it faster"
        )
    return there[0]
