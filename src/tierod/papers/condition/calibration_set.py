"""What every diagnosis of the study is calibrated on: healthy driving alone, the same for all of them."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from tierod.core.recording import Recording
from tierod.papers.condition.drives import calibration_drives
from tierod.papers.condition.recorded import recorded

QUICK_SECONDS = 80.0
"""Of driving that the parameters of a quick study come from; little more than a calibration takes at all."""
QUICK_DRIVES = 2
"""Of ten minutes each, that limits of a quick study come from: with less they cannot be designed at all."""


class CalibrationSet(NamedTuple):
    """Recordings of a sound vehicle.

    Args:
        fitted: that parameters are found in
        healthy: that limits and thresholds are designed on
    """

    fitted: list[Recording]
    healthy: list[Recording]


def calibration_set(number: int, quick: bool, drives: int = QUICK_DRIVES) -> CalibrationSet:
    """Five healthy minutes of a vehicle and an hour; 80 seconds and a few drives of ten minutes if quick.

    Args:
        number: of the vehicle
        quick: whether a few minutes have to do
        drives: how many of ten minutes then
    """
    first, hour = calibration_drives(number)
    first = replace(first, seconds=QUICK_SECONDS) if quick else first
    return CalibrationSet([recorded(first)], [recorded(each) for each in (hour[:drives] if quick else hour)])
