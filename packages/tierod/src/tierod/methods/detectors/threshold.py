"""Debouncing of a condition."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import any_of, both, maximum, minimum, negated, where
from tierod.methods.detectors.value import Condition, counts, number


@dataclass(frozen=True)
class Debounce:
    """Debounced condition: on once the condition has held for a time, off once it has been false for a time.

    Args:
        on_time: time for which the condition must hold without interruption [s]; every further sample multiplies the
            time between false alarms by 1 / (probability of one), if samples are independent
        off_time: time for which it must be false without interruption until the output is off [s]
        sample_time: sampling interval [s]

    With a false condition of probability p per independent sample, and n = on_time / sample_time samples, false alarms
    are (1 / p^n - 1) / (1 - p) samples apart.

    An unknown condition, or a sample that is not enabled, neither confirms nor interrupts a run.
    """

    on_time: Annotated[float, "s"]
    off_time: Annotated[float, "s"]
    sample_time: Annotated[float, "s"]

    Sample = Condition

    class State(NamedTuple):
        """The output, and the time for which the condition has contradicted it [s]."""

        active: float
        against: float

    class Output(NamedTuple):
        """The debounced condition (1.0 or 0.0), and the progress towards its next change (0 to 1)."""

        active: Annotated[float, ""]
        progress: Annotated[float, ""]

    def __post_init__(self) -> None:
        _require_times(on_time=self.on_time, off_time=self.off_time)
        _require_sample_time(self.sample_time)

    def init(self) -> State:
        return self.State(0.0, 0.0)

    def step(self, state: State, sample: Condition | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        """State and output after one sample of the condition; `enabled` (logic) is whether the sample counts."""
        condition = number(sample)
        use = counts(condition, enabled)
        holds = where(condition > 0.5, 1.0, 0.0)
        differs = any_of(both(holds, negated(state.active)), both(negated(holds), state.active))
        needed = where(state.active, self.off_time, self.on_time)
        against = where(use, where(differs, state.against + self.sample_time, 0.0), state.against)
        switch = both(both(use, differs), against + 0.5 * self.sample_time > needed)
        active = where(switch, 1.0 - state.active, state.active)
        progress = where(switch, 0.0, minimum(against / maximum(needed, self.sample_time), 1.0))
        return self.State(active, where(switch, 0.0, against)), self.Output(active, progress)


def _require_times(**times: float) -> None:
    for name, value in times.items():
        if not value >= 0.0:
            raise ParameterError(f"{name} is {value}; expected a time that is not negative [s]")


def _require_sample_time(value: float) -> None:
    if not value > 0.0:
        raise ParameterError(f"sample_time is {value}; expected a time greater than zero [s]")
