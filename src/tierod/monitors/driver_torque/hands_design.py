"""Thresholds of the hands monitor from a wanted time between false changes, measured on healthy recordings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from tierod.detectors import Cusum
from tierod.detectors.measured import FEWEST, MeasuredPoint
from tierod.errors import InputError
from tierod.graph import scan
from tierod.monitors.driver_torque.hands import HandsMonitor

SETTLED = 1.0
"""After hands have come or gone their evidence is that of the change, not of what lasts, for so long [s]."""


LADDER = tuple(0.5 * number for number in range(1, 61))
"""Thresholds that are tried, in nats, until hardly a false alarm is left."""


TAIL = 8
"""Of these the highest that make the line: below them it is steeper."""


class HeldRecord(NamedTuple):
    """A recording in which it is known whether hands were on the wheel.

    Args:
        samples: angle [rad] and torque of the bar [N*m], (n, 2)
        held: 1 where hands held the wheel, 0 where none did, (n,)
    """

    samples: np.ndarray
    held: np.ndarray


class RatioDesign(NamedTuple):
    """A threshold for sums of coloured log-likelihood ratios.

    Args:
        threshold: of the sum
        growth: of the logarithm of the time between false alarms, per unit of the threshold
        longest: samples between false alarms at the highest threshold that had enough of them
        points: what was counted
    """

    threshold: float
    growth: float
    longest: float
    points: tuple[MeasuredPoint, ...]


def threshold_from_ratios(records: Sequence[np.ndarray], samples: float) -> RatioDesign:
    """The threshold of a sum with so many samples between false alarms.

    The increments are coloured, so that no formula for white ones serves: false alarms are counted at thresholds low
    enough to have some, and the logarithm of their distance is carried on in a straight line. Beyond some hundred times
    what was observed that is a hope, no measurement.

    Args:
        records: log-likelihood ratios of what is not the case against what is, (n,) each; NaN where they do not count
        samples: wanted between false alarms

    Raises:
        InputError: too few false alarms to measure their distance, or evidence that grows where it must not
    """
    count = sum(int(np.isfinite(record).sum()) for record in records)
    if not sum(float(np.nansum(record)) for record in records) < 0.0:
        raise InputError("the evidence is not against what is not the case: records of the other case, or a wrong sign")
    points = []
    for threshold in LADDER:
        block = Cusum(0.0, threshold, threshold, "upper", True)
        alarms = sum(int(scan(block, record[:, None])["alarm"].sum()) for record in records)
        if alarms < FEWEST:
            break
        points.append(MeasuredPoint(threshold, alarms, count / alarms))
    if len(points) < 3:
        raise InputError(
            f"the records hold {count} samples and too few false alarms to measure their distance; give longer ones"
        )
    tail = points[-TAIL:]
    heights, lengths = [each.threshold for each in tail], np.log([each.run_length for each in tail])
    growth, start = np.polyfit(heights, lengths, 1, w=np.sqrt([each.alarms for each in tail]))
    threshold = float((np.log(samples) - start) / growth)
    return RatioDesign(threshold, float(growth), points[-1].run_length, tuple(points))


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
