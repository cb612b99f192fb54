"""Design of stopping rules: their requirements, and a comparison of rules by their detection delay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from tierod.core.block import Block
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors.control_charts import Cusum, Detector
from tierod.methods.detectors.stopping_rules import CusumRule, HoldRule, StoppingRule


@dataclass(frozen=True)
class RunLengthLine:
    """Time between false alarms as a function of the threshold, fitted to counts on fault-free records."""

    start: float  # start, slope: ln(values between false alarms) = start + slope * growth of the threshold
    slope: float
    observed: float

    def __post_init__(self) -> None:
        if not (self.slope > 0.0 and self.observed > 0.0):
            raise ParameterError(
                f"slope is {self.slope} and observed {self.observed}; expected both above zero: false alarms must grow "
                "rarer with the threshold"
            )


@dataclass(frozen=True)
class RuleDesign:
    """A stopping rule with the tolerated rate of false alarms."""

    rule: StoppingRule  # with its constant, in standard deviations of the distance
    values: float  # wanted mean number of values between false alarms
    shift: float  # that must be detected, in standard deviations, greater than zero
    spacing: Annotated[float, "s"]  # time between two values [s]; infinite where there is one value in each recording
    # fitted to fault-free records; None where the values are white, so that the rule calculates its run length
    line: RunLengthLine | None = None

    @cached_property
    def threshold(self) -> float:
        """Threshold for `values`, in standard deviations or as evidence."""
        return self.threshold_for(self.values)

    def threshold_for(self, values: float) -> float:
        """The threshold for a mean number of values between false alarms."""
        if self.line is None:
            return self.rule.threshold_for(values)
        grown = (math.log(values) - self.line.start) / self.line.slope
        if not grown > 0.0:
            raise ParameterError(f"{values:g} values between false alarms need no threshold; ask for more")
        # The growth of every rule is a power of its threshold, so that two values give the exponent.
        power = math.log2(self.rule.growth(2.0) / self.rule.growth(1.0))
        return float((grown / self.rule.growth(1.0)) ** (1.0 / power))

    def run_length(self, threshold: float) -> float:
        """Values between false alarms at another threshold."""
        if self.line is None:
            return self.rule.run_length(threshold)
        return math.exp(min(self.line.start + self.line.slope * self.rule.growth(threshold), 700.0))

    def delay(self, threshold: float, shift: float | None = None) -> float:
        """Detection delay [values] of a shift, by default the one that must be detected.

        The mean for white values. Autocorrelated noise hardly changes while a sum grows, so that only the shift counts.
        """
        change = self.shift if shift is None else shift
        block = self.rule.block(threshold, 1.0)
        if self.line is not None and isinstance(block, Cusum):
            return math.ceil(block.threshold / (change - block.drift)) if change > block.drift else math.inf
        return self.rule.run_length(threshold, -change if self.rule.sides == "lower" else change)

    def block(self, deviation: float = 1.0) -> Detector:
        return self.rule.block(self.threshold, deviation)


def alarms_at(block: Detector, distance: float) -> bool:
    """Whether a block alarms at a single value, as from one recording; a missing value (NaN) raises no alarm."""
    return bool(block.step(block.init(), distance)[1].alarm > 0.5)


HOLDS = (2, 3, 5, 8, 12, 20, 30)  # Candidate counts; near the optimum the delays of neighbours differ by a few per cent
RULES = ("cusum", "hold", "threshold")  # Names of the rules that a user can choose


@dataclass(frozen=True)
class Designed:
    rule: StoppingRule
    threshold: float
    samples: float  # wanted mean number of samples between false alarms
    delay: float  # mean detection delay of the shift [samples]

    def delay_at(self, change: float) -> float:
        """Mean detection delay [samples] of another shift, which is given in standard deviations."""
        return self.rule.run_length(self.threshold, change if self.rule.sides != "lower" else -change)


def designed(name: str, shift: float, samples: float, sides: str = "both") -> Designed:
    """A rule with the constant of the shortest delay, and its threshold for a time between false alarms."""
    found: list[Designed] = []
    refused: list[ParameterError] = []
    for rule in _candidates(name, shift, samples, sides):
        try:
            found.append(_with_threshold(rule, shift, samples))
        except ParameterError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    return min(found, key=lambda each: each.delay)


def _candidates(name: str, shift: float, samples: float, sides: str) -> list[StoppingRule]:
    from scipy.special import ndtri

    if name != "cusum":
        return [HoldRule(hold, sides=sides) for hold in (HOLDS if name == "hold" else (1,))]
    # Limited, so that a drift of half of the shift still needs a positive threshold.
    sought = min(shift, 1.8 * float(-ndtri(1.0 / samples))) if samples > 10.0 else shift
    return [CusumRule(0.5 * sought, sides=sides)]


def _with_threshold(rule: StoppingRule, shift: float, samples: float) -> Designed:
    threshold = rule.threshold_for(samples)
    delay = rule.run_length(threshold, -shift if rule.sides == "lower" else shift)
    return Designed(rule, threshold, samples, delay)


TRIALS = 200


def delays_of(
    block: Block, records: Sequence[np.ndarray], shift: float, trials: int = TRIALS, seed: int = 0
) -> np.ndarray:
    """Samples from the start of a shift to the alarm, for many starts; infinite where the shift is not detected.

    A start at which the block already is in alarm is left out: that alarm is a false one. A shift that is not detected
    within half of the record, or within 20 000 samples, counts as not detected.

    Args: block: with an output `alarm`; it first runs over the residuals before the shift; records: fault-free
    residuals, (n,) each; the longest one is used; shift: added to the residual [its unit].
    """
    longest = max(records, key=len, default=np.zeros(0))
    if len(longest) < 200:
        raise InputError(f"the longest residual has {len(longest)} samples; expected 200 or more to insert shifts")
    random = np.random.default_rng(seed)
    reach = min(len(longest) // 2, 20_000)
    delays = []
    for start in random.integers(len(longest) // 10, len(longest) - reach, trials):
        before = scan(block, longest[max(start - reach, 0) : start])
        if before["alarm"][-1] > 0.5:
            continue
        alarms = np.flatnonzero(scan(block, longest[start : start + reach] + shift, before.state)["alarm"] > 0.5)
        delays.append(float(alarms[0] + 1) if len(alarms) else np.inf)
    if not delays:
        raise InputError("the detector is in alarm wherever a shift is inserted; allow fewer false alarms")
    return np.array(delays)


# Smallest number of alarms of a point of the fitted line: its ln(run length) has a standard error of a third
FEWEST = 8


@dataclass(frozen=True)
class MeasuredPoint:
    """False alarms at one threshold on fault-free residuals."""

    threshold: float  # in standard deviations of the residual
    alarms: int
    run_length: float  # mean number of samples between two of them


@dataclass(frozen=True)
class MeasuredDesign:
    """A threshold from fault-free residuals."""

    rule: StoppingRule  # that the threshold belongs to
    deviation: Annotated[float, "unit of the signal"]  # root mean square of the residual [unit of the residual]
    threshold: float  # in these deviations
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

        Args: rate: sample rate of the residuals [Hz].
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

    Args: records: fault-free residuals [unit of the residual], (n,) each; NaN where missing.
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
    low, high = 0.05, 1.0
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
    alarms = int(sum(scan(block, record)["alarm"].sum() for record in records))
    return MeasuredPoint(threshold, alarms, count / alarms if alarms else math.inf)


def _inverse(rule: StoppingRule, growth: float, known: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda h: rule.growth(h) - growth, 1e-9, 1e3 * known + 1e3))
