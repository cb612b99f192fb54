"""A threshold that must be exceeded in several samples one after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import absolute, both, minimum, where
from tierod.methods.detectors.cusum import SIDES
from tierod.methods.detectors.value import Value, counts, number


@dataclass(frozen=True)
class HeldThreshold:
    """Alarm when a residual has been at a threshold or beyond in `hold` samples one after the other.

    Args:
        threshold: [unit of the residual]
        hold: samples
        sides: "both", "upper" or "lower"
        restart: whether the count starts anew after an alarm, which makes of every alarm one sample

    With a chance p per independent sample, false alarms are (1 / p^hold - 1) / (1 - p) samples apart. A missing value,
    or one that is not enabled, neither counts nor breaks the run.
    """

    threshold: Annotated[float, "unit of the signal"]
    hold: int = 1
    sides: str = "both"
    restart: bool = False

    Sample = Value

    class State(NamedTuple):
        """Samples beyond, one after the other."""

        held: float

    class Output(NamedTuple):
        """Samples beyond, one after the other, up to `hold`; and whether they are `hold` (1.0) or fewer (0.0)."""

        held: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.sides not in SIDES:
            raise ParameterError(f"sides is '{self.sides}'; expected {', '.join(SIDES)}")
        if not (self.threshold > 0.0 and self.hold >= 1):
            raise ParameterError(
                f"threshold is {self.threshold} and hold {self.hold}; expected a threshold above zero and 1 or more"
            )

    def init(self) -> State:
        """None."""
        return self.State(0.0)

    def step(self, state: State, sample: Any, enabled: Any = True) -> tuple[State, Output]:
        """One value on; `enabled` (logic) says whether it counts."""
        value = number(sample)
        watched = {"both": absolute(value), "upper": value, "lower": -value}[self.sides]
        use = counts(value, enabled)
        more = minimum(state.held + 1.0, float(self.hold))
        held = where(use, where(both(use, watched >= self.threshold), more, 0.0), state.held)
        alarm = where(held > self.hold - 0.5, 1.0, 0.0)
        return self.State(where(alarm, 0.0, held) if self.restart else held), self.Output(held, alarm)
