"""Time grid of calibrations, and detection of motion on it."""

from __future__ import annotations

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Aligned, Recording
from tierod.monitors.condition.signals import WHEELS, ConditionSample

RATE = 100.0
"""Rate of the grid [Hz]; filters and limits are designed for its steps."""
SLOWEST = 10.0
"""Rate of wheel speeds below which a recording is refused, as by the monitor [Hz]."""
MAXIMUM_AGE = 0.0099
"""Age from which a reading counts as missing [s]; just below the step of the grid, so that every reading is used only
once, whatever the clock of its bus."""
HELD = 0.5
"""Time for which a wheel speed is held after its last reading [s]; readings come less often than the grid's steps, or
fail."""
MOVING = 1.0
"""Speed of a wheel from which the vehicle counts as moving [m/s]."""


def sampled(recording: Recording, rate: float = RATE) -> Aligned:
    """Samples of a recording as the monitor receives them.

    Args:
        recording: recording with signals of `ConditionSample`; missing ones become NaN
        rate: sampling rate [Hz]
    """
    return recording.align(ConditionSample._fields, rate, maximum_age=MAXIMUM_AGE)


def aligned(recording: Recording, rate: float = RATE) -> np.ndarray:
    """Values of a recording on the grid, (n, signals).

    Args:
        recording: recording with signals of `ConditionSample`; missing ones become NaN
        rate: sampling rate [Hz]
    """
    return sampled(recording, rate).values


def moving(rows: np.ndarray, rate: float = RATE) -> np.ndarray:
    """Whether the vehicle moves, forwards or backwards, according to the available rear wheels, (n,).

    Args:
        rows: wheel speeds in the first two columns; NaN if missing, (n, 2 or more)
        rate: sampling rate [Hz]
    """
    place, found = np.arange(len(rows)), np.zeros(len(rows), bool)
    for speed in rows[:, : len(WHEELS)].T:
        last = np.maximum.accumulate(np.where(np.isfinite(speed), place, -1))
        fresh = (last >= 0) & (place - last <= HELD * rate)
        found |= fresh & (np.abs(speed[np.maximum(last, 0)]) > MOVING)
    return found


def wheel_of(name: str, recording: Recording) -> str:
    """Name of the wheel speed signal of a recording, that of the rear left wheel if it has both rear wheels.

    Args:
        name: name of the recording, for the message
        recording: recording to be searched

    Raises:
        InputError: the recording has neither signal, or its rate is too low
    """
    there = [each for each in WHEELS if each in recording and len(recording[each].time)]
    if not there:
        raise InputError(
            f"{name} has neither {WHEELS[0]} nor {WHEELS[1]}: calibration needs one of them; 'tierod inspect' shows "
            "which signals it has"
        )
    time = recording[there[0]].time
    rate = 1.0 / float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if rate < 0.99 * SLOWEST:
        raise InputError(
            f"{name} has {there[0]} at {rate:.3g} Hz; calibration needs {SLOWEST:g} Hz, better the {RATE:g} Hz of the "
            "monitor: record it faster"
        )
    return there[0]
