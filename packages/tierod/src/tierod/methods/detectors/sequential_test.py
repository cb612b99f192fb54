"""Sequential probability ratio test, restarted after every decision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import either, maximum, where
from tierod.methods.detectors.value import Detector, Value, counts, number


@dataclass(frozen=True)
class SequentialTest:
    """Test of a shifted mean against a mean of zero that decides as soon as the evidence suffices.

    The log-likelihood ratio grows by shift / deviation^2 (value - shift / 2) per value. At `upper` the test decides for
    the shift, at `lower` against it; then it restarts from zero.

    Args:
        shift: of the mean to be detected, with its sign [unit of the residual]
        deviation: standard deviation of the residual [same unit]
        upper: evidence for the shift at which the alarm is raised; ln((1 - missed) / false alarms) for one test
        lower: evidence against the shift, below zero; ln(missed / (1 - false alarms))

    A missing value, or one that is not enabled, leaves the evidence unchanged.

    Source: A. Wald, 1945, doi 10.1214/aoms/1177731118.
    """

    shift: Annotated[float, "unit of the signal"]
    deviation: Annotated[float, "unit of the signal"]
    upper: Annotated[float, ""]
    lower: Annotated[float, ""]

    Sample = Value

    class State(NamedTuple):
        """Accumulated log-likelihood ratio."""

        evidence: float

    class Output(NamedTuple):
        """Evidence, alarm (1.0 on a decision for the shift), decision (1.0 shift, -1.0 no shift, 0.0 none yet)."""

        evidence: Annotated[float, ""]
        alarm: Annotated[float, ""]
        decision: Annotated[float, ""]

    def __post_init__(self) -> None:
        if self.shift == 0.0 or not self.deviation > 0.0:
            raise ParameterError(
                f"shift is {self.shift} and deviation {self.deviation}; expected a shift and a deviation above zero"
            )
        if not self.lower < 0.0 < self.upper:
            raise ParameterError(f"lower is {self.lower} and upper {self.upper}; expected lower below 0 below upper")

    def init(self) -> State:
        return self.State(0.0)

    def step(self, state: State, sample: Value | Scalar, enabled: Truth = True) -> tuple[State, Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        value = number(sample)
        slope = self.shift / (self.deviation * self.deviation)
        evidence = state.evidence + where(counts(value, enabled), slope * (value - 0.5 * self.shift), 0.0)
        shifted, fault_free = evidence >= self.upper, evidence <= self.lower
        decision = where(shifted, 1.0, where(fault_free, -1.0, 0.0))
        after = where(either(shifted, fault_free), 0.0, evidence)
        return self.State(after), self.Output(evidence, where(shifted, 1.0, 0.0), decision)


@dataclass(frozen=True)
class TwoSided:
    """Alarm when one of two detectors alarms.

    Args:
        up, down: detectors with an output `alarm`
    """

    up: Detector
    down: Detector

    Sample = Value

    class Output(NamedTuple):
        """Whether one of the detectors alarms (1.0) or neither (0.0)."""

        alarm: Annotated[float, ""]

    def init(self) -> tuple[Tree, Tree]:
        return self.up.init(), self.down.init()

    def step(
        self, state: tuple[Tree, Tree], sample: Value | Scalar, enabled: Truth = True
    ) -> tuple[tuple[Tree, Tree], Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        up, above = self.up.step(state[0], sample, enabled)
        down, below = self.down.step(state[1], sample, enabled)
        return (up, down), self.Output(maximum(above.alarm, below.alarm))
