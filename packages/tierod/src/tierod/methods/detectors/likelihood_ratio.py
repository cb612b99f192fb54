"""Generalised likelihood ratio for a shift of the mean by an unknown amount at an unknown instant."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Truth
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import maximum, where
from tierod.methods.detectors.moments import MovingMoments
from tierod.methods.detectors.value import Value

WINDOWS = (4, 8, 16, 32, 64, 128)
"""Lengths of the windows [samples]; for a shift of a length between two of them up to 1 - sqrt(1/2), 29 %, of the
evidence is lost."""


@dataclass(frozen=True)
class LikelihoodRatio:
    """Alarm when the mean of a residual over one of several windows differs significantly from zero.

    For each window of n values with mean m the evidence is n m^2 / (2 deviation^2), the log-likelihood ratio at the
    maximum-likelihood shift; the output is the largest.

    Args:
        deviation: standard deviation of the residual [unit of the residual]
        threshold: evidence at which the alarm is raised
        windows: lengths [samples]

    An alarm does not reset the windows: it lasts until the shift has left them. Missing values, and those not enabled,
    are left out.

    Source: A. S. Willsky, H. L. Jones, 1976, doi 10.1109/TAC.1976.1101146; windows after T. L. Lai, 1995.
    """

    deviation: Annotated[float, "unit of the signal"]
    threshold: Annotated[float, ""]
    windows: tuple[int, ...] = WINDOWS
    moments: tuple[MovingMoments, ...] = field(init=False, repr=False)

    Sample = Value

    class Output(NamedTuple):
        """Largest evidence, the mean of the window that gives it, and whether it reaches the threshold (1.0)."""

        evidence: Annotated[float, ""]
        shift: Annotated[float, ""]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        if not (self.deviation > 0.0 and self.threshold > 0.0):
            raise ParameterError(
                f"deviation is {self.deviation} and threshold {self.threshold}; expected both greater than zero"
            )
        if not self.windows or list(self.windows) != sorted(set(self.windows)):
            raise ParameterError(f"windows is {self.windows}; expected lengths that rise, each given once")
        object.__setattr__(self, "moments", tuple(MovingMoments(size) for size in self.windows))

    def init(self) -> tuple[MovingMoments.State, ...]:
        return tuple(moments.init() for moments in self.moments)

    def step(
        self, state: tuple[MovingMoments.State, ...], sample: Value | Scalar, enabled: Truth = True
    ) -> tuple[tuple[MovingMoments.State, ...], Output]:
        """State and output after one value; `enabled` (logic) is whether the value counts."""
        after, evidence, shift = [], 0.0, 0.0
        for moments, held in zip(self.moments, state, strict=True):
            advanced, found = moments.step(held, sample, enabled)
            after.append(advanced)
            own = 0.5 * found.number * (found.mean / self.deviation) * (found.mean / self.deviation)
            shift = where(own > evidence, found.mean, shift)
            evidence = maximum(evidence, own)
        return tuple(after), self.Output(evidence, shift, where(evidence >= self.threshold, 1.0, 0.0))
