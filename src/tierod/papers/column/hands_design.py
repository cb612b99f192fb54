"""Thresholds of the hands monitor from a wanted time between false changes, measured on healthy recordings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from tierod.core.graph import scan
from tierod.methods.detectors.measured_ratios import RatioDesign, threshold_from_ratios
from tierod.monitors.driver_torque.hands import HandsMonitor

SETTLED = 1.0
"""After hands have come or gone their evidence is that of the change, not of what lasts, for so long [s]."""


class HeldRecord(NamedTuple):
    """A recording in which it is known whether hands were on the wheel.

    Args:
        samples: angle [rad] and torque of the bar [N*m], (n, 2)
        held: 1 where hands held the wheel, 0 where none did, (n,)
    """

    samples: np.ndarray
    held: np.ndarray


class HandsDesign(NamedTuple):
    """What was measured for both changes.

    Args:
        to_on: evidence that it takes to say "on", from data without hands
        to_off: evidence that it takes to say "off", from data with hands
    """

    to_on: RatioDesign
    to_off: RatioDesign

    @property
    def thresholds(self) -> tuple[float, float]:
        """As `HandsMonitor.of_vehicle` takes them."""
        return self.to_on.threshold, self.to_off.threshold


def design_thresholds(monitor: HandsMonitor, records: Iterable[HeldRecord], hours: float) -> HandsDesign:
    """Thresholds with so many hours between false changes.

    Args:
        monitor: whose thresholds are high enough to make no false change in the records
        records: healthy ones, of vehicles as different from the file as is to be borne
        hours: between two false changes to "on" while hands are off, and likewise to "off" while they are on [h]

    Raises:
        InputError: too few records to measure it
    """
    without, with_ = [], []
    for record in records:
        ratio = scan(monitor, record.samples)["log_likelihood_ratio"]
        settled = _settled(record.held, round(SETTLED / monitor.sample_time))
        without.append(np.where(settled & (record.held == 0.0), ratio, np.nan))
        with_.append(np.where(settled & (record.held == 1.0), -ratio, np.nan))
    wanted = 3600.0 * hours / monitor.sample_time
    return HandsDesign(threshold_from_ratios(without, wanted), threshold_from_ratios(with_, wanted))


def _settled(held: np.ndarray, count: int) -> np.ndarray:
    """Where nothing has changed for so many samples."""
    place = np.arange(len(held))
    changed = np.maximum.accumulate(np.where(np.diff(held, prepend=np.nan) != 0.0, place, 0))
    return place - changed >= count
