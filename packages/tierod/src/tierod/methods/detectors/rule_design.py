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
from tierod.methods.detectors.stopping_rules import AverageRule, CusumRule, HoldRule, SequentialRule, StoppingRule


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
        """The threshold for a mean number of values between false alarms.

        Raises:
            ParameterError: so few that no threshold is needed
        """
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


WEIGHTS = (0.5, 0.3, 0.2, 0.12, 0.08, 0.05, 0.03, 0.02, 0.01, 0.005)
HOLDS = (2, 3, 5, 8, 12, 20, 30)
"""Candidate weights and hold counts; near the optimum the delay differs by a few per cent between neighbours."""

RULES = ("cusum", "average", "sequential", "hold", "threshold")  # Names of the rules that a user can choose


@dataclass(frozen=True)
class Designed:
    """A rule with its threshold."""

    rule: StoppingRule
    threshold: float
    samples: float  # wanted mean number of samples between false alarms
    delay: float  # mean detection delay of the shift [samples]

    def delay_at(self, change: float) -> float:
        """Mean detection delay [samples] of another shift, which is given in standard deviations."""
        return self.rule.run_length(self.threshold, change if self.rule.sides != "lower" else -change)


def designed(name: str, shift: float, samples: float, sides: str = "both") -> Designed:
    """A rule with the constant that minimises the detection delay, and the threshold for a time between false alarms.

    Args:
        shift: to be detected, in standard deviations, greater than zero
        sides: "both", "upper" or "lower"

    Raises:
        ParameterError: so few samples that no threshold is needed
    """
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
    if name == "average":
        return [AverageRule(weight, sides=sides) for weight in WEIGHTS]
    if name == "hold":
        return [HoldRule(hold, sides=sides) for hold in HOLDS]
    sought = _sought(shift, samples)
    one: dict[str, StoppingRule] = {
        "cusum": CusumRule(0.5 * sought, sides=sides),
        "sequential": SequentialRule(sought, sides=sides),
        "threshold": AverageRule(1.0, sides=sides),
    }
    return [one[name]]


def _sought(shift: float, samples: float) -> float:
    """The shift that a rule is designed for, limited so that a drift of half of it still needs a positive threshold."""
    from scipy.special import ndtri

    return min(shift, 1.8 * float(-ndtri(1.0 / samples))) if samples > 10.0 else shift


def _with_threshold(rule: StoppingRule, shift: float, samples: float) -> Designed:
    threshold = rule.threshold_for(samples)
    change = -shift if rule.sides == "lower" else shift
    delay = rule.run_length(threshold, change)
    return Designed(rule, threshold, samples, delay)


TRIALS = 200


def delays_of(
    block: Block, records: Sequence[np.ndarray], shift: float, trials: int = TRIALS, seed: int = 0
) -> np.ndarray:
    """Samples from the start of a shift to the alarm, for many starts; infinite where the shift is not detected.

    Args:
        block: with an output `alarm`; it first runs over the residuals before the shift
        records: fault-free residuals, (n,) each; the longest one is used
        shift: added to the residual [its unit]

    A start at which the block already is in alarm is left out: that alarm is a false one. A shift that is not detected
    within half of the record, or within 20 000 samples, counts as not detected.

    Raises:
        InputError: records too short to add shifts, or the block is in alarm throughout
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
