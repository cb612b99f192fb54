"""A stopping rule together with the requirements for its threshold, to be reported, plotted and checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

from tierod.core.errors import ParameterError
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.stopping_rules import StoppingRule
from tierod.methods.detectors.value import Detector


@dataclass(frozen=True)
class RunLengthLine:
    """Time between false alarms as a function of the threshold, fitted to counts on fault-free records.

    Args:
        start, slope: ln(values between false alarms) = start + slope * growth of the threshold
    """

    start: float
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
    """A stopping rule with the tolerated rate of false alarms.

    Args:
        rule: with its constant, in standard deviations of the distance
        values: wanted mean number of values between false alarms
        shift: that must be detected, in standard deviations, greater than zero
        spacing: time between two values [s]; infinite where there is one value in each recording
        line: fitted to fault-free records; None where the values are white, so that the rule calculates its run length
    """

    rule: StoppingRule
    values: float
    shift: float
    spacing: Annotated[float, "s"]
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
