"""A level that must be exceeded by so much for so long: a cumulative sum whose drift is what is designed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tierod.core.errors import ParameterError
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.stopping_rules import CusumRule, StoppingRule


@dataclass(frozen=True)
class ExcessRule(StoppingRule):
    """Alarm when what lies above a level has added up to `excess`; the level is the threshold.

    Where the level is given by what is worth an alarm, and a residual remembers for longer than the excess takes, no
    sum ever begins in fault-free data. The time between false alarms then grows with the level; it is measured over
    that.

    Args:
        excess: standard deviations times values: one deviation for this many values, or more for as many fewer
    """

    excess: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.excess < math.inf:
            raise ParameterError(f"excess is {self.excess}; expected a number greater than zero")

    @property
    def name(self) -> str:
        """In a word or two, with its constant."""
        return f"level exceeded by {self.excess:.3g} deviations times values"

    def run_length(self, threshold: float, change: float = 0.0) -> float:
        """Expected samples until the alarm, of white residuals."""
        return CusumRule(threshold, sides=self.sides).run_length(self.excess, change)

    def block(self, threshold: float, deviation: float, restart: bool = False) -> Cusum:
        """The block."""
        height = self.excess * deviation
        return Cusum(threshold * deviation, height, 2.0 * height, sides=self.sides, restart=restart)
