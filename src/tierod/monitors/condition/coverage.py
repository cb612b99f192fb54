"""When a recording tells enough to be judged: some sensor, and what was asked of every actuator."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.monitors.condition.signals import SENSORS, ConditionSample

LOST = 1.0
"""Without a reading for so long, a signal is missing and not merely slow [s]."""
ALL = 4
"""Sensors from which on their reading exactly zero in one sample, all of them, is the loss of what they share."""

TARGETS = (
    "steering_motor_1_target_torque",
    "steering_motor_2_target_torque",
    "target_drive_torque_left",
    "target_drive_torque_right",
)
"""What is asked of every actuator, in their order."""

_NEEDED = [ConditionSample._fields.index(name) for name in (*SENSORS, *TARGETS)]
_COUNT = len(SENSORS)


class Covered(NamedTuple):
    """Over n samples.

    Args:
        available: whether every sensor is read, and every actuator is asked for a torque that is known, (n, elements)
        judged: whether anything can be judged, (n,)
        zero: whether all sensors read exactly zero, (n,)
    """

    available: np.ndarray
    judged: np.ndarray
    zero: np.ndarray


class Coverage:
    """Follows which signals come, piece by piece; the result does not depend on how a recording is cut.

    Without the targets nobody knows what moves the vehicle, and all sensors would be blamed for it.

    Args:
        rate: of the samples [Hz]
    """

    def __init__(self, rate: float):
        self.interruptions = 0
        self._limit = round(LOST * rate)
        self._age = np.full(len(_NEEDED), np.inf)
        self._judged = False

    def add(self, values: np.ndarray) -> tuple[np.ndarray, Covered]:
        """The next piece.

        Args:
            values: columns of `ConditionSample`, (n, signals); NaN where missing

        Returns:
            the same without readings of sensors that have lost what they share, and what there is of it
        """
        zero = all_zero(values[:, :_COUNT])
        if zero.any():
            values = values.copy()
            values[zero, :_COUNT] = np.nan
        there = np.isfinite(values[:, _NEEDED])
        place = np.arange(len(values), dtype=float)[:, None]
        age = place - np.maximum.accumulate(np.where(there, place, -1.0 - self._age), axis=0)
        fresh = np.asarray(age <= self._limit)
        judged = np.asarray(fresh[:, :_COUNT].any(axis=1) & fresh[:, _COUNT:].all(axis=1))
        before = np.concatenate([[self._judged], judged[:-1]])
        self.interruptions += int(np.count_nonzero(before & ~judged))
        self._age, self._judged = age[-1], bool(judged[-1])
        return values, Covered(fresh, judged, zero)


def all_zero(readings: np.ndarray) -> np.ndarray:
    """Whether all sensors that there are read exactly zero: a bus or a supply that is gone, or a vehicle that stands.

    Args:
        readings: (n, sensors); NaN where missing
    """
    there = np.isfinite(readings)
    return np.asarray((there.sum(axis=1) >= ALL) & (~there | (readings == 0.0)).all(axis=1))
