"""Isolation of the wrong one of three angles, from motion, the motor's observer, and the variable ratio."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, any_of, limit, where
from tierod.methods.detectors.threshold import Debounce

NONE, MOTOR, WHEEL, PINION, NOT_MOTOR = 0.0, 1.0, 2.0, 3.0, 4.0
"""Codes of the suspected angle; the last one means the steering wheel's or the pinion's."""


class Opinions(NamedTuple):
    """Evidence from the comparison of the angles in one sample.

    Args:
        mismatch, alarm, suspect, detour: outputs of `AnglePlausibility`
        residual: motor angle sensor less observer, electrical
        counts: 1 where that residual is known
    """

    mismatch: Annotated[Scalar, "rad"]
    alarm: Annotated[Scalar, ""]
    suspect: Annotated[Scalar, ""]
    detour: Annotated[Scalar, "rad"]
    residual: Annotated[Scalar, "rad"]
    counts: Annotated[Scalar, ""]


@dataclass(frozen=True)
class WhichAngle:
    """Code of the wrong one of the motor's, the steering wheel's and the pinion's angle.

    The observer is further evidence: since the mismatch began it has agreed with the motor's sensor, or not. If not,
    the motor's angle is wrong. If so, one of the other two is: the one isolated by motion; or the steering wheel's,
    where the motor deviates from the variable ratio's target for the recorded angle. Otherwise the wrong one of the two
    is unknown: a control that reads the same wrong wheel angle follows it.

    Args:
        sample_time: sampling interval [s]
        greatest: mismatch of the three from which it has begun, at the pinion [rad]; half of the alarm limit
        agreement: largest electrical residual in agreement [rad]; ten standard deviations of a fault-free one
        needed: excess of residuals in agreement over those not, or the reverse, for a decision [-]
        widest_detour: largest deviation of the motor from its target, at the pinion [rad]; following error of a
            fault-free drive
        hold: time for which the deviation must be larger [s]
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    greatest: Annotated[float, "rad", POSITIVE] = 0.01
    agreement: Annotated[float, "rad", POSITIVE] = 0.1
    needed: Annotated[float, "", POSITIVE] = 20.0
    widest_detour: Annotated[float, "rad", POSITIVE] = 0.04
    hold: Annotated[float, "s", POSITIVE] = 0.05
    holding: Debounce = field(init=False, repr=False)

    Sample = Opinions

    class State(NamedTuple):
        """Whether the angles disagree, the first angle by motion, score of the observer, hold of the deviation."""

        apart: Annotated[Scalar, ""]
        by_motion: Annotated[Scalar, ""]
        score: Annotated[Scalar, ""]
        held: Debounce.State

    class Output(NamedTuple):
        """Code of the wrong angle, 0 where none is wrong or isolated."""

        suspect: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, NONE, 0.0, self.holding.init())

    def step(self, state: State, sample: Opinions) -> tuple[State, Output]:
        """Process one sample."""
        apart = where(absolute(sample.mismatch) > self.greatest, 1.0, 0.0)
        begins = all_of(apart > 0.5, state.apart < 0.5)
        opinion = where(absolute(sample.residual) < self.agreement, 1.0, -1.0)
        score = where(begins, 0.0, state.score) + where(sample.counts > 0.5, opinion, 0.0)
        score = limit(score, -2.0 * self.needed, 2.0 * self.needed)
        held, detour = self.holding.step(state.held, where(absolute(sample.detour) > self.widest_detour, 1.0, 0.0))
        # The evidence by motion is taken when the alarm comes; later the motion itself depends on the fault.
        unknown = any_of(begins, state.by_motion < 0.5)
        by_motion = where(unknown, where(sample.alarm > 0.5, sample.suspect, NONE), state.by_motion)
        elsewhere = any_of(absolute(by_motion - WHEEL) < 0.5, absolute(by_motion - PINION) < 0.5)
        other = where(elsewhere, by_motion, where(detour.active, WHEEL, NOT_MOTOR))
        decided = where(score <= -self.needed, MOTOR, where(score >= self.needed, other, by_motion))
        after = self.State(apart, by_motion, score, held)
        return after, self.Output(where(sample.alarm > 0.5, decided, NONE))
