"""Geometric moving average as a stopping rule."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, where
from tierod.methods.detectors.cusum import SIDES
from tierod.methods.detectors.value import Value, counts, number


@dataclass(frozen=True)
class GeometricAverage:
    """Alarm when the exponentially forgetting mean of a residual has left a band.

    average <- average + weight (value - average); alarm while it is at `threshold` or beyond.

    Args:
        weight: of the newest value, 0 to 1; small finds small shifts, large finds large ones sooner
        threshold: average that means alarm [unit of the residual]
        sides: "both", "upper" (increases only) or "lower"
        restart: whether the average starts anew from zero after an alarm, which makes of every alarm one sample

    For white residuals of standard deviation sigma the average has sigma sqrt(weight / (2 - weight)).
    `tierod.methods.detectors.stopping_rules` gives the threshold for a wanted time between false alarms.

    A missing value, or one that is not enabled, leaves the average as it is.

    Source: S. W. Roberts, 1959, doi 10.1080/00401706.1959.10489860.
    """

    weight: Annotated[float, ""]
    threshold: Annotated[float, "unit of the signal"]
    sides: str = "both"
    restart: bool = False

    Sample = Value

    class State(NamedTuple):
        """The average."""

        average: float

    class Output(NamedTuple):
        """The average, and whether it is at the threshold or beyond (1.0) or not (0.0)."""

        average: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.sides not in SIDES:
            raise ParameterError(f"sides is '{self.sides}'; expected {', '.join(SIDES)}")
        if not 0.0 < self.weight <= 1.0:
            raise ParameterError(f"weight is {self.weight}; expected more than 0 and at most 1")
        if not self.threshold > 0.0:
            raise ParameterError(f"threshold is {self.threshold}; expected a number greater than zero")

    def init(self) -> State:
        """Nothing averaged."""
        return self.State(0.0)

    def step(self, state: State, sample: Any, enabled: Any = True) -> tuple[State, Output]:
        """One value on; `enabled` (logic) says whether it counts."""
        value = number(sample)
        average = state.average + self.weight * where(counts(value, enabled), value - state.average, 0.0)
        watched = {"both": absolute(average), "upper": average, "lower": -average}[self.sides]
        alarm = where(watched >= self.threshold, 1.0, 0.0)
        after = where(alarm, 0.0, average) if self.restart else average
        return self.State(after), self.Output(average, alarm)
