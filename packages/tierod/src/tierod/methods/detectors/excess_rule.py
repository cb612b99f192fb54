"""A level that must be exceeded by a given sum: a cumulative sum of which the drift is designed, not the threshold."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tierod.core.errors import ParameterError
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.stopping_rules import CusumRule, StoppingRule


@dataclass(frozen=True)
class ExcessRule(StoppingRule):
    """Alarm when the excess of values over a level has added up to `excess`; the level is the threshold of this rule.

    With a level set by the smallest fault magnitude, and residuals whose correlation time exceeds the time that the sum
    takes, no sum ever starts in fault-free data. The time between false alarms then depends on the level, over which it
    is measured.

    Args:
        excess: sum over values, in standard deviations: one standard deviation for this many values, or a larger excess
            for fewer
    """

    excess: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.excess < math.inf:
            raise ParameterError(f"excess is {self.excess}; expected a number greater than zero")

    @property
    def name(self) -> str:
        return f"level exceeded by {self.excess:.3g} deviations times values"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, for white residuals."""
        return CusumRule(threshold, sides=self.sides).run_length(self.excess, change)

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        height = self.excess * deviation
        return Cusum(threshold * deviation, height, 2.0 * height, sides=self.sides, restart=restart)
