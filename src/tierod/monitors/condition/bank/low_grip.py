"""Tyres that slide: a filter that hardly trusts the forces of the axles, and whether it explains most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, either, greatest_of, limit, maximum, where
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.signals import DRIVES
from tierod.physics.lag import share_reached

FORCE, FORCE_SHARE, TIE_ROD_SHARE = 60.0, 0.6, 0.3
"""Lasting error of an axle's force where its tyres may slide, at small force [N], and its growth with the force; growth
of that of the tie rod. Ice takes most of the force that the tyres have on a dry road, and most of their trail."""
ACCELERATION = 1.0
"""Error of the acceleration along the road there, white, per sample [m/s**2]: wheels that have spun push the vehicle on
when they grip again, whatever is asked of them by then."""
LARGEST_FORCE_ERROR = 4000.0
"""Beyond which no error of an axle's force goes there: more than an axle gives on a dry road [N]."""


class LowGripState(NamedTuple):
    """State of the check for low grip.

    Args:
        lead: mean log-likelihood ratio of the filter of sliding tyres against the best other one
        lead_along: likewise, against the best of those that explain a lack of force along the vehicle, over a while
        gain: likewise, against the filter that suspects nothing
        symmetric: for how many samples in a row force along the vehicle has been lacking on both sides alike
        held: greatest force that both drives gave since then, over the load of their axle
        broken: for how many samples in a row they have given less than that, and less than was asked for
        left: samples for which tyres still count as sliding
    """

    lead: Scalar
    lead_along: Scalar
    gain: Scalar
    symmetric: Scalar
    held: Scalar
    broken: Scalar
    left: Scalar


class Lack(NamedTuple):
    """Force that an axle lacks over its load, see `LeaveOutFilter.Output`.

    Args:
        across: in a bend
        along: of what is asked of the drives
        given: that the drives give
    """

    across: Scalar
    along: Scalar
    given: Scalar


@dataclass(frozen=True)
class LowGrip:
    """Whether tyres slide now, by the filter of `sliding`.

    Across the vehicle they do where it explains the readings of all sensors better than any filter that leaves one out,
    and an axle has far less force in a bend than its tyres' slip would give it on a dry road. A fault of a sensor lets
    sensors contradict each other, which weak tyres do not explain; a lost drive takes no force from an axle.

    Along the vehicle they do where the driven axle has not the force that is asked of it, while nothing turns the
    vehicle: one lost drive would, and its own filter then explains the readings better by more than that of sliding
    tyres loses where they grip. They go on sliding while force is lacking, and for a while: filters have to find back.
    Both drives without a share of their torque look the same, until less is asked for than ice has held: it would give
    all of that, they still give a share.

    All of it was chosen on braking, driving off and bends on ice of three virtual demonstrators (adhesion .15 to .4)
    and on their lost drives, in samples of 10 ms, and held against 81 other drives on ice: one of these, declared
    faulty at first, showed that no time passes while the vehicle stands.

    Args:
        leads: by how much it must explain the readings better [nat per sample]; to leave one reading out costs 4 to 9
        time_across: constant of that mean
        lacks: force that an axle must lack across, over its load
        loses: by how much the filter of a drive may explain the readings better; that of a drive without 50 to 100 % of
            its torque does by 0.9 and more, that of one that slides with the other one by 0.6 at most
        time_along: constant of that mean
        largest_along: ratio of a single sample that counts in it: a drive's filter takes a moment to see what it lost
        samples: in a row that all of this must hold along the vehicle
        gains: by how much the filter that suspects nothing must explain them worse
        time_gain: constant of that mean
        contradicts: by how much any filter may explain them better at once; that of a faulty sensor does by far more
        lacks_along: force that the driven axle must lack, over its load
        least: force that it must have, over its load: the smoothest ice holds more, drives without any torque give none
        below: share of what they held, up to which tyres that slide would give all that is asked for
        part: of what is asked for, below which it is not given; where less than the rest of it is, ice may hold no more
        in_full: share of what is asked for up to which nothing is lacking
        share: of a sample in the force that is held
        proofs: samples in a row in which drives give too little of what ice has held, so that both have lost torque
        stays: so long they slide after they did
        impossible: ratio from which on the filter that suspects nothing has not found back
        slower: so much slower time passes until it has
        largest: ratio of a single sample that counts
    """

    leads: Annotated[float, ""] = 3.0
    time_across: Annotated[float, "s"] = 0.05
    lacks: Annotated[float, ""] = 0.15
    loses: Annotated[float, ""] = 0.75
    time_along: Annotated[float, "s"] = 0.5
    largest_along: Annotated[float, ""] = 3.0
    samples: Annotated[float, ""] = 6.0
    gains: Annotated[float, ""] = 1.5
    time_gain: Annotated[float, "s"] = 0.2
    contradicts: Annotated[float, ""] = 1.0
    lacks_along: Annotated[float, ""] = 0.06
    least: Annotated[float, ""] = 0.05
    below: Annotated[float, ""] = 0.85
    part: Annotated[float, ""] = 0.75
    in_full: Annotated[float, ""] = 0.15
    share: Annotated[float, ""] = 0.1
    proofs: Annotated[float, ""] = 10.0
    stays: Annotated[float, "s"] = 0.5
    impossible: Annotated[float, ""] = 12.0
    slower: Annotated[float, ""] = 0.25
    largest: Annotated[float, ""] = 20.0

    def init(self) -> LowGripState:
        """The tyres grip."""
        return LowGripState(*(0.0,) * len(LowGripState._fields))

    def after(
        self,
        state: LowGripState,
        likelihood: Scalar,
        others: Sequence[Scalar],
        drives: Sequence[Scalar],
        lack: Lack,
        moving: Scalar,
        sample_time: float,
    ) -> tuple[LowGripState, Scalar]:
        """One sample on; whether tyres slide.

        Args:
            state: after the sample before
            likelihood: logarithm of the density of this sample where tyres slide
            others: likewise, of all hypotheses with tyres that hold, the fault-free one first
            drives: likewise, of those that suspect one drive alone
            lack: of force
            moving: whether the vehicle goes forward; while it stands or goes back no time passes to find back in
            sample_time: [s]
        """
        healthy, best = others[0], greatest_of(*others)

        def on(mean: Scalar, against: Scalar, time: float, largest: float) -> Scalar:
            return mean + share_reached(sample_time / time) * (limit(likelihood - against, -largest, largest) - mean)

        lead = on(state.lead, best, self.time_across, self.largest)
        lead_along = on(state.lead_along, greatest_of(healthy, *drives), self.time_along, self.largest_along)
        gain = on(state.gain, healthy, self.time_gain, self.largest)
        across, along = lack.across > self.lacks, absolute(lack.along) > self.lacks_along
        gives = absolute(lack.given) > self.least
        held = where(state.left > 0.5, maximum(state.held, self._steady(state.held, lack)), 0.0)
        broken = self._broken(state.broken, held, lack)
        alike = all_of(along, gives, lead_along > -self.loses, gain > self.gains, lead > -self.contradicts)
        symmetric = where(alike, state.symmetric + 1.0, 0.0)
        begins = either(both(across, lead > self.leads), both(symmetric >= self.samples, broken < self.proofs))
        goes_on = both(state.left > 0.5, either(across, both(along, broken < self.proofs)))
        slides = either(begins, goes_on)
        lost = healthy < maximum(best, likelihood) - self.impossible
        left = maximum(state.left - where(moving, where(lost, self.slower, 1.0), 0.0), 0.0)
        left = where(slides, self.stays / sample_time, left)
        return LowGripState(lead, lead_along, gain, symmetric, held, broken, left), left > 0.5

    def _steady(self, held: Scalar, lack: Lack) -> Scalar:
        """A step towards the given force while some of the requested force is lacking."""
        lacks = lack.given * lack.along > 0.0
        return held + self.share * (where(lacks, absolute(lack.given), held) - held)

    def _broken(self, before: Scalar, held: Scalar, lack: Lack) -> Scalar:
        """Number of samples in a row with less than the requested force, where no more is requested than ice held.

        Kept while too little or too much is asked for to show it; none where all is given.
        """
        asked, given = absolute(lack.given + lack.along), absolute(lack.given)
        shows = both(asked > self.lacks_along, lack.given * lack.along > 0.0)
        full = both(asked > self.lacks_along, absolute(lack.along) < self.in_full * asked)
        misses = all_of(shows, asked < self.below * held, given < self.part * asked, given > (1.0 - self.part) * asked)
        known = before >= self.proofs
        return where(full, 0.0, where(misses, before + 1.0, where(known, before, 0.0)))


def sliding(base: LeaveOutFilter) -> LeaveOutFilter:
    """The filter that trusts all sensors, hardly the forces of the axles, and no drive: both lose the same share.

    Args:
        base: the filter that suspects nothing
    """
    error = replace(
        base.model_error,
        acceleration=ACCELERATION,
        force=FORCE,
        force_share=FORCE_SHARE,
        tie_rod_share=TIE_ROD_SHARE,
        drive_excess=0.0,
    )
    trusted = base.trusted._replace(**dict.fromkeys(DRIVES, 0.0))
    return replace(base, model_error=error, largest_force_error=LARGEST_FORCE_ERROR, trusted=trusted)
