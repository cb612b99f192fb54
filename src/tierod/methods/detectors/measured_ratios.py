"""Thresholds for sums of log-likelihood ratios that are not white: measured on records in which one case holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.measured import FEWEST, MeasuredPoint

LADDER = tuple(0.5 * number for number in range(1, 61))
"""Thresholds that are tried, in nats, until hardly a false alarm is left."""

TAIL = 8
"""Of these the highest that make the line: below them it is steeper."""


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
        InputError: too few false alarms to measure their distance, a distance that does not grow with the threshold, or
            evidence that grows where it must not
    """
    records = [np.asarray(record, float) for record in records]
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
    if not min(growth, lengths[-1] - lengths[0]) > 0.0:
        raise InputError("the time between false alarms does not grow with the threshold; give longer records")
    threshold = float((np.log(samples) - start) / growth)
    return RatioDesign(threshold, float(growth), points[-1].run_length, tuple(points))
