"""Shares of two torques that are lost, by least squares that forget."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import exp, present, where
from tierod.core.ranges import POSITIVE


@dataclass(frozen=True)
class LostShares:
    """How much of each of two regressors is missing in a sum: missing = first share * first + second share * second.

    Args:
        memory: time in which the past is forgotten; longer is less noisy and later
        doubt: size of the regressors below which the shares are drawn to zero, in their unit
        sample_time: between two samples

    Regressors that keep one proportion are collinear: then both shares are equal, drawn by the doubt alone.
    """

    memory: Annotated[float, "s", POSITIVE]
    doubt: Annotated[float, "unit of the signal", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE]

    class Sample(NamedTuple):
        """What is missing in the sum, and both regressors."""

        missing: Annotated[float, "unit of the signal"]
        first: Annotated[float, "unit of the signal"]
        second: Annotated[float, "unit of the signal"]

    class State(NamedTuple):
        """Forgetting means of the products."""

        first: Any
        mixed: Any
        second: Any
        missing_first: Any
        missing_second: Any

    class Output(NamedTuple):
        """Both shares."""

        first: Annotated[float, ""]
        second: Annotated[float, ""]

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: Sample, enabled: Any = True) -> tuple[State, Output]:
        """One sample on; where `enabled` (logic) does not hold it is held."""
        whole = (sample.missing + sample.first + sample.second) * 0.5
        use = where(present(whole), enabled, 0.0)
        missing, first, second = (where(use, value, 0.0) for value in sample)
        keep = exp(-self.sample_time / self.memory)
        products = (first * first, first * second, second * second, missing * first, missing * second)
        after = self.State(
            *(where(use, keep * old + (1.0 - keep) * new, old) for old, new in zip(state, products, strict=True))
        )
        square = self.doubt * self.doubt
        a, b, c = after.first + square, after.mixed, after.second + square
        determinant = a * c - b * b
        shares = (
            (c * after.missing_first - b * after.missing_second) / determinant,
            (a * after.missing_second - b * after.missing_first) / determinant,
        )
        return after, self.Output(*shares)
