"""Time that a condition has held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, maximum, where
from tierod.methods.detectors.threshold import Condition
from tierod.methods.detectors.value import counts, number


@dataclass(frozen=True)
class GatedCounter:
    """How long a condition has held in all, and which share of the enabled time that is.

    Args:
        sample_time: time between two samples [s]

    An unknown condition (NaN) counts as false: it is time in which the condition was not seen to hold. What is not
    enabled counts on neither side. Samples are counted, so that the time stays exact over hours.
    """

    sample_time: Annotated[float, "s"]

    Sample = Condition

    class State(NamedTuple):
        """Enabled samples in which the condition held, and all enabled samples."""

        held: float
        all: float

    class Output(NamedTuple):
        """Time [s] in which the condition held, and its share of the enabled time (0 to 1)."""

        duration: Annotated[float, "s"]
        share: Annotated[float, ""]

    def __post_init__(self) -> None:
        if not self.sample_time > 0.0:
            raise ParameterError(f"sample_time is {self.sample_time}; expected a time greater than zero [s]")

    def init(self) -> State:
        """Nothing counted."""
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Any, enabled: Any = True) -> tuple[State, Output]:
        """One sample of the condition on; `enabled` (logic) says whether it counts."""
        use = counts(0.0, enabled)
        held = both(use, number(sample) > 0.5)
        after = self.State(state.held + where(held, 1.0, 0.0), state.all + where(use, 1.0, 0.0))
        return after, self.Output(after.held * self.sample_time, after.held / maximum(after.all, 1.0))
