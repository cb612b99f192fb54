"""Thresholds for sums of autocorrelated log-likelihood ratios, measured on records in which one hypothesis holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.measured import FEWEST, MeasuredPoint

LADDER = tuple(0.5 * number for number in range(1, 61))
"""Candidate thresholds [nat], in rising order until too few false alarms are left."""

TAIL = 8
"""Number of the highest of them that the line is fitted to: at lower ones the slope is larger."""


class RatioDesign(NamedTuple):
    """A threshold for sums of autocorrelated log-likelihood ratios.

    Args:
        threshold: of the sum [nat]
        growth: increase of ln(time between false alarms) per unit of the threshold
        longest: samples between false alarms at the highest threshold with at least `FEWEST` of them
        points: false alarms at each threshold
    """

    threshold: float
    growth: float
    longest: float
    points: tuple[MeasuredPoint, ...]


def threshold_from_ratios(records: Sequence[np.ndarray], samples: float) -> RatioDesign:
    """The threshold of a sum for a mean number of samples between false alarms.

    The increments are autocorrelated, so that the formulas for white ones do not hold: false alarms are counted at low
    thresholds, and the logarithm of the time between them is extrapolated linearly. Beyond some hundred times the
    observed time the result is an assumption, not a measurement.

    Args:
        records: log-likelihood ratios of a false hypothesis against the true one, (n,) each; NaN where left out
        samples: wanted mean number between false alarms

    Raises:
        InputError: too few false alarms to measure the time between them, a time that does not grow with the threshold,
            or log-likelihood ratios that favour the false hypothesis
    """
    records = [np.asarray(record, float) for record in records]
    count = sum(int(np.isfinite(record).sum()) for record in records)
    if not sum(float(np.nansum(record)) for record in records) < 0.0:
        raise InputError(
            "the log-likelihood ratios do not decrease on average; check their sign, and that the "
            "records are not of the other case"
        )
    points = []
    for threshold in LADDER:
        # No drift is subtracted, since the ratios themselves have a negative mean.
        block = Cusum(0.0, threshold, threshold, "upper", True)
        alarms = sum(int(scan(block, record[:, None])["alarm"].sum()) for record in records)
        if alarms < FEWEST:
            break
        points.append(MeasuredPoint(threshold, alarms, count / alarms))
    if len(points) < 3:
        raise InputError(
            f"the records hold {count} samples and too few false alarms to measure the time between them; give longer "
            "ones"
        )
    tail = points[-TAIL:]
    heights, lengths = [each.threshold for each in tail], np.log([each.run_length for each in tail])
    growth, start = np.polyfit(heights, lengths, 1, w=np.sqrt([each.alarms for each in tail]))
    if not min(growth, lengths[-1] - lengths[0]) > 0.0:
        raise InputError("the time between false alarms does not grow with the threshold; give longer records")
    threshold = float((np.log(samples) - start) / growth)
    return RatioDesign(threshold, float(growth), points[-1].run_length, tuple(points))
