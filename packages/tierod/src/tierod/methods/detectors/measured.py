"""Thresholds for autocorrelated residuals: measured on fault-free data, and extrapolated with a stated uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.methods.detectors.stopping_rules import StoppingRule

FEWEST = 8
"""Smallest number of alarms of a point of the fitted line: its ln(run length) has a standard error of a third."""


@dataclass(frozen=True)
class MeasuredPoint:
    """False alarms at one threshold on fault-free residuals."""

    threshold: float  # in standard deviations of the residual, or as evidence
    alarms: int
    run_length: float  # mean number of samples between two of them


@dataclass(frozen=True)
class MeasuredDesign:
    """A threshold from fault-free residuals."""

    rule: StoppingRule  # that the threshold belongs to
    deviation: Annotated[float, "unit of the signal"]  # root mean square of the residual [unit of the residual]
    threshold: float  # in these deviations, or as evidence
    wanted: float  # mean number of samples between false alarms
    # low, high: 95 % interval of the run length at this threshold [samples]; beyond the observed time it assumes that
    # the fitted line continues, which is not tested
    low: float
    high: float
    observed: int  # number of fault-free samples
    points: tuple[MeasuredPoint, ...]  # false alarms at the thresholds that were tried

    @property
    def extrapolated(self) -> bool:
        """Whether fewer than `FEWEST` false alarms are expected in the observed samples at this threshold."""
        return self.wanted * FEWEST > self.observed

    def claim(self, rate: float) -> str:
        """Statement on the false alarms that the measurement supports, as a sentence.

        Args:
            rate: sample rate of the residuals [Hz]
        """
        hours = self.observed / rate / 3600.0
        unit, name = (3600.0, "h") if self.low / rate > 3600.0 else (1.0, "s")
        low, high = (float(f"{length / rate / unit:.3g}") for length in (self.low, self.high))
        span = f"{low:,g} to {high:,g} {name}".replace(",", " ")
        if not self.extrapolated:
            return f"measured: 95 % interval {span} between false alarms"
        bound = 3.0 / hours  # rule of three: 95 % bound of a Poisson rate without an event
        return (
            f"extrapolated from shorter run lengths ({span} at 95 % if the line continues); {hours:.3g} h without an "
            f"alarm would show fewer than {bound:.3g} per hour at 95 %, no more"
        )


def threshold_from_records(rule: StoppingRule, records: Sequence[np.ndarray], samples: float) -> MeasuredDesign:
    """The threshold for a mean number of samples between false alarms, from fault-free residuals, white or not.

    The logarithm of the run length is linear in the threshold (in its square for averages) once alarms are rare: the
    line is fitted where alarms are frequent enough to be counted, weighted by their number, and extrapolated.

    Args:
        records: fault-free residuals [unit of the residual], (n,) each; NaN where missing

    Raises:
        InputError: too few fault-free residuals, or residuals that are all zero, not about zero, or drifting
    """
    records = [np.asarray(record, float) for record in records]
    whole = np.concatenate(records) if records else np.zeros(0)
    present = whole[np.isfinite(whole)]
    if len(present) < 1000:
        raise InputError(f"{len(present)} healthy residuals are too few to measure a threshold on; give 1000 or more")
    deviation = float(np.sqrt(np.mean(present**2)))
    if not deviation > 0.0:
        raise InputError("the healthy residuals are all zero; a threshold cannot be measured on them")
    mean = float(np.mean(present))
    if abs(mean) > 0.5 * deviation:
        raise InputError(
            f"the healthy residuals have a mean of {mean:.3g} and a root mean square of {deviation:.3g}; a fault-free "
            "residual is about zero on average: remove its mean first"
        )
    points = _ladder(rule, records, deviation, len(present), samples)
    usable = [point for point in points if point.alarms >= FEWEST]
    if len(usable) < 2:
        raise InputError("the healthy residuals raise too few alarms to measure a run length; give a longer record")
    tail = usable[-_TAIL:]
    growth = np.array([rule.growth(point.threshold) for point in tail])
    lengths = np.log([point.run_length for point in tail])
    weights = np.sqrt([point.alarms for point in tail])
    (slope, intercept), spread = np.polyfit(growth, lengths, 1, w=weights, cov="unscaled")
    if not slope > 0.0:
        raise InputError("the run length does not grow with the threshold: the residuals drift; remove the drift first")
    at = (math.log(samples) - intercept) / slope
    # Neighbouring thresholds count largely the same alarms, so the line is no more certain than its last count.
    own = math.sqrt(float(np.array([at, 1.0]) @ spread @ np.array([at, 1.0])) + 1.0 / tail[-1].alarms)
    threshold = _inverse(rule, at, tail[-1].threshold)
    low, high = (samples * math.exp(way * 1.96 * own) for way in (-1.0, 1.0))
    return MeasuredDesign(rule, deviation, threshold, samples, low, high, len(present), tuple(points))


_STEPS, _TAIL = 14, 6


def _ladder(
    rule: StoppingRule, records: Sequence[np.ndarray], deviation: float, count: int, samples: float
) -> list[MeasuredPoint]:
    points: list[MeasuredPoint] = []
    low, high = 0.05 * rule.unit, rule.unit
    while len(points) < _STEPS and _measured(rule, high, records, deviation, count).alarms >= FEWEST:
        low, high = high, 1.5 * high
    for threshold in np.linspace(0.25 * low, high, _STEPS):
        point = _measured(rule, float(threshold), records, deviation, count)
        points.append(point)
        if point.alarms < FEWEST or point.run_length > 3.0 * samples:
            break
    return points


def _measured(
    rule: StoppingRule, threshold: float, records: Sequence[np.ndarray], deviation: float, count: int
) -> MeasuredPoint:
    block = rule.block(threshold, deviation, restart=True)
    alarms = sum(rule.alarms(scan(block, record)["alarm"]) for record in records)
    return MeasuredPoint(threshold, alarms, count / alarms if alarms else math.inf)


def _inverse(rule: StoppingRule, growth: float, known: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda h: rule.growth(h) - growth, 1e-9, 1e3 * known + 1e3))
