"""Isolation of the wrong one of three angles: motion, the motor's observer, and the variable ratio together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, any_of, limit, where
from tierod.methods.detectors.threshold import Debounce

NONE, MOTOR, WHEEL, PINION, NOT_MOTOR = 0.0, 1.0, 2.0, 3.0, 4.0
"""Codes of the angle that is suspected; the last: the steering wheel's or the pinion's."""


class Opinions(NamedTuple):
    """Comparison of the angles at one instant.

    Args:
        mismatch, alarm, suspect, detour: of `AnglePlausibility`
        residual: the motor's sensor less its observer, electrical
        counts: 1 where that value is known
    """

    mismatch: Annotated[Scalar, "rad"]
    alarm: Annotated[Scalar, ""]
    suspect: Annotated[Scalar, ""]
    detour: Annotated[Scalar, "rad"]
    residual: Annotated[Scalar, "rad"]
    counts: Annotated[Scalar, ""]


@dataclass(frozen=True)
class WhichAngle:
    """The wrong one of motor's, steering wheel's and pinion's angle, by its code.

    The observer is a fourth opinion: since the disagreement began it has stood by the motor's sensor, or against it. If
    against, the motor's is the wrong one. If by it, one of the other two is: the one that motion betrays; or the
    steering wheel's, where the motor departs from the variable ratio's target for the recorded angle. Otherwise
    only that it is not the motor's is known: a control that reads the same wrong wheel follows it.

    Args:
        sample_time: [s]
        greatest: disagreement of the three from which it has begun, at the pinion: half of what alarms [rad]
        agreement: of sensor and observer, electrical; ten times the deviation of a fault-free residual [rad]
        needed: values by which more were by the sensor than against it, or fewer []
        widest_detour: of the motor from its wanted course, at the pinion: following error of a fault-free drive [rad]
        hold: for so long [s]
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
        """Whether the angles disagree, the first angle by motion, the observer's score, hold of the detour."""

        apart: Annotated[Scalar, ""]
        by_motion: Annotated[Scalar, ""]
        score: Annotated[Scalar, ""]
        held: Debounce.State

    class Output(NamedTuple):
        """Code of the angle that is wrong, 0 where none is, or none stands out."""

        suspect: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, NONE, 0.0, self.holding.init())

    def step(self, state: State, sample: Opinions) -> tuple[State, Output]:
        """One sample on."""
        apart = where(absolute(sample.mismatch) > self.greatest, 1.0, 0.0)
        begins = all_of(apart > 0.5, state.apart < 0.5)
        opinion = where(absolute(sample.residual) < self.agreement, 1.0, -1.0)
        score = where(begins, 0.0, state.score) + where(sample.counts > 0.5, opinion, 0.0)
        score = limit(score, -2.0 * self.needed, 2.0 * self.needed)
        held, detour = self.holding.step(state.held, where(absolute(sample.detour) > self.widest_detour, 1.0, 0.0))
        # What moved how is fresh when the alarm comes; later on motion itself depends on the fault.
        unknown = any_of(begins, state.by_motion < 0.5)
        by_motion = where(unknown, where(sample.alarm > 0.5, sample.suspect, NONE), state.by_motion)
        elsewhere = any_of(absolute(by_motion - WHEEL) < 0.5, absolute(by_motion - PINION) < 0.5)
        other = where(elsewhere, by_motion, where(detour.active, WHEEL, NOT_MOTOR))
        decided = where(score <= -self.needed, MOTOR, where(score >= self.needed, other, by_motion))
        after = self.State(apart, by_motion, score, held)
        return after, self.Output(where(sample.alarm > 0.5, decided, NONE))
