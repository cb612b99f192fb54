"""Cumulative sum detector."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import either, maximum, minimum, where
from tierod.methods.detectors.value import Value, counts, number

SIDES = ("both", "upper", "lower")


@dataclass(frozen=True)
class Cusum:
    """Alarm when a residual has been above (or below) zero by more than `drift` for long enough.

    up <- max(0, up + value - drift), down <- max(0, down - value - drift); alarm while one is at `threshold` or above.

    Args:
        drift: what is forgiven per sample [unit of the residual]: half of the smallest change worth an alarm. Larger
            ignores slow drifts and model error; smaller finds smaller changes and alarms falsely more often
        threshold: sum that means alarm [same unit]. The delay grows in proportion, about threshold / (change - drift)
            samples; the time between false alarms grows exponentially
        ceiling: the sums are held to this [same unit], at least the threshold: after a long fault it takes at most
            ceiling / drift healthy samples until the alarm ends
        sides: "both", "upper" (increases only) or "lower"
        restart: whether the sums start anew after an alarm, which makes of every alarm one sample

    For white Gaussian residuals of standard deviation sigma, one side, with k = drift / sigma and
    b = threshold / sigma + 1.166, the expected number of samples between false alarms is about
    (exp(2 k b) - 2 k b - 1) / (2 k^2): 938 for k = 0.5, threshold 5 sigma; half of it for both sides. Correlated
    residuals alarm far more often. `tierod.methods.detectors.design` gives the threshold for a wanted number.

    A missing value, or one that is not enabled, leaves the sums as they are.

    Source: E. S. Page, 1954, doi 10.1093/biomet/41.1-2.100; run length, D. Siegmund, Sequential Analysis, 1985, (2.57).
    """

    drift: Annotated[float, "unit of the signal"]
    threshold: Annotated[float, "unit of the signal"]
    ceiling: Annotated[float, "unit of the signal"]
    sides: str = "both"
    restart: bool = False

    Sample = Value

    class State(NamedTuple):
        """The two sums."""

        up: float
        down: float

    class Output(NamedTuple):
        """Sums (0 on a side that is not watched), and whether one has reached the threshold (1.0) or not (0.0)."""

        up: Annotated[float, ""]
        down: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.sides not in SIDES:
            raise ParameterError(f"sides is '{self.sides}'; expected {', '.join(SIDES)}")
        if not self.threshold > 0.0:
            raise ParameterError(f"threshold is {self.threshold}; expected a number greater than zero")
        if not self.drift >= 0.0:
            raise ParameterError(f"drift is {self.drift}; expected a number that is not negative")
        if not self.ceiling >= self.threshold:
            raise ParameterError(f"ceiling is {self.ceiling}; expected at least the threshold, {self.threshold}")

    def init(self) -> State:
        """Nothing summed."""
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Any, enabled: Any = True) -> tuple[State, Output]:
        """One value on; `enabled` (logic) says whether it counts."""
        value = number(sample)
        use = counts(value, enabled)
        up, down = state
        alarm: Any = 0.0
        if self.sides != "lower":
            up = where(use, minimum(maximum(0.0, up + value - self.drift), self.ceiling), up)
            alarm = up >= self.threshold
        if self.sides != "upper":
            down = where(use, minimum(maximum(0.0, down - value - self.drift), self.ceiling), down)
            alarm = either(alarm, down >= self.threshold) if self.sides == "both" else down >= self.threshold
        alarm = where(alarm, 1.0, 0.0)
        after = self.State(up, down)
        if self.restart:
            after = self.State(where(alarm, 0.0, up), where(alarm, 0.0, down))
        return after, self.Output(up, down, alarm)
