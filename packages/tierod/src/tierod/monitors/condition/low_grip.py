"""Filters of a rolling car with sliding tyres, and the criterion for sliding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, all_of, both, either, greatest_of, limit, maximum, where
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.signals import DRIVES
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.physics.friction import share_reached

FORCE, FORCE_SHARE, TIE_ROD_SHARE = 60.0, 0.6, 0.3
"""Lasting error of an axle force in the filter of sliding tyres: at small force [N], and its growth with the force [-];
growth of the error of the tie-rod force [-]. On ice, most of the force of a dry road and of the trail is lost."""
ACCELERATION = 1.0
"""White error of the longitudinal acceleration per sample in that filter [m/s**2]; spinning wheels that regain grip
push the vehicle whatever torque is requested by then."""
LARGEST_FORCE_ERROR = 4000.0
"""Bound of the error of an axle force in that filter [N]; more than an axle transmits on a dry road."""


class LowGripState(NamedTuple):
    """State of the check for low grip."""

    lead: Scalar  # mean log-likelihood ratio of the filter of sliding tyres to the best other one [nat]
    # the same to the best filter that can explain a lack of longitudinal force, over a longer time [nat]
    lead_along: Scalar
    gain: Scalar  # the same to the filter of the fault-free hypothesis [nat]
    symmetric: Scalar  # number of consecutive samples in which both sides lacked longitudinal force alike
    held: Scalar  # greatest force that both drives transmitted while tyres slid, over the load of their axle
    broken: Scalar  # number of samples in which the drives gave less than that and less than requested
    left: Scalar  # number of samples for which tyres still count as sliding


class Lack(NamedTuple):
    """Force that an axle lacks, over its load; see `LeaveOutFilter.Output`."""

    across: Scalar  # lacking lateral force in a bend
    along: Scalar  # lacking part of the requested drive force
    given: Scalar  # drive force that is transmitted


@dataclass(frozen=True)
class LowGrip:
    """Test whether the tyres slide now, with the likelihood of the filter of `sliding`.

    Across the vehicle the tyres slide if that filter explains the readings of all sensors better than any filter that
    leaves one out, and an axle has far less force in a bend than the slip of its tyres gives on a dry road. With a
    faulty sensor the readings contradict each other, which weak tyres do not explain; a lost drive takes no lateral
    force from an axle.

    Along the vehicle the tyres slide if the driven axle does not transmit the requested force while nothing turns the
    vehicle. The loss of one drive would turn it, and the filter of that drive would then lead by more than it does
    when both wheels slide. Sliding lasts while force is lacking, and for a time afterwards in which the filters
    recover. A loss of the same share of both drives looks alike until less force is requested than the ice has
    transmitted: ice would transmit all of it, faulty drives still give a share.

    All numbers were chosen on braking, driving off and bends on ice of three virtual demonstrators (adhesion .15 to .4)
    and on their lost drives, in samples of 10 ms, and checked on 81 other drives on ice: one of these, first declared
    faulty, showed that the time to recover must not count down while the vehicle stands.
    """

    # least mean lead of the filter of sliding tyres [nat per sample]; leaving out one reading costs 4 to 9
    leads: Annotated[float, ""] = 3.0
    time_across: Annotated[float, "s"] = 0.05  # time constant of that mean
    lacks: Annotated[float, ""] = 0.15  # least lateral force that an axle lacks, over its load
    # largest mean lead of the filter of a drive [nat per sample]; after a loss of 50 to 100 % of its torque it leads by
    # 0.9 and more, and by 0.6 at most if both wheels slide
    loses: Annotated[float, ""] = 0.75
    time_along: Annotated[float, "s"] = 0.5  # time constant of that mean
    # bound of the ratio of a single sample in that mean [nat]; the filter of a drive takes some time to estimate the
    # loss
    largest_along: Annotated[float, ""] = 3.0
    # number of consecutive samples in which all conditions along the vehicle must hold
    samples: Annotated[float, ""] = 6.0
    gains: Annotated[float, ""] = 1.5  # least mean lead over the filter of the fault-free hypothesis [nat per sample]
    time_gain: Annotated[float, "s"] = 0.2  # time constant of that mean
    # largest lead of any other filter over `time_across` [nat]; that of a faulty sensor leads by more
    contradicts: Annotated[float, ""] = 1.0
    lacks_along: Annotated[float, ""] = 0.06  # least longitudinal force that the driven axle lacks, over its load
    # least force that it transmits, over its load; even smooth ice transmits more, failed drives give none
    least: Annotated[float, ""] = 0.05
    # share of the force held before, below which sliding tyres would transmit all that is requested
    below: Annotated[float, ""] = 0.85
    # share of the requested force below which it counts as not given; if less than 1 - `part` is given, the ice may
    # have become slippier instead
    part: Annotated[float, ""] = 0.75
    in_full: Annotated[float, ""] = 0.15  # largest lacking share of the requested force that counts as none
    share: Annotated[float, ""] = 0.1  # weight of one sample in the force that is held
    # number of samples with too little of a force that the ice has held after which both drives have lost torque
    proofs: Annotated[float, ""] = 10.0
    stays: Annotated[float, "s"] = 0.5  # time for which tyres count as sliding after they have slid
    # log-likelihood ratio from which the filter of the fault-free hypothesis has not recovered [nat]
    impossible: Annotated[float, ""] = 12.0
    slower: Annotated[float, ""] = 0.25  # factor on the passage of that time until it has recovered
    largest: Annotated[float, ""] = 20.0  # bound of the ratio of a single sample in the other means [nat]

    def init(self) -> LowGripState:
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
        """Low-pass filtered force that is transmitted while a part of the requested force is lacking."""
        lacks = lack.given * lack.along > 0.0
        return held + self.share * (where(lacks, absolute(lack.given), held) - held)

    def _broken(self, before: Scalar, held: Scalar, lack: Lack) -> Scalar:
        """Number of samples with less force than requested, although the ice has held more than that before.

        Once it has reached `proofs` it is kept until the requested force is given in full.
        """
        asked, given = absolute(lack.given + lack.along), absolute(lack.given)
        shows = both(asked > self.lacks_along, lack.given * lack.along > 0.0)
        full = both(asked > self.lacks_along, absolute(lack.along) < self.in_full * asked)
        misses = all_of(shows, asked < self.below * held, given < self.part * asked, given > (1.0 - self.part) * asked)
        known = before >= self.proofs
        return where(full, 0.0, where(misses, before + 1.0, where(known, before, 0.0)))


def sliding(base: LeaveOutFilter) -> LeaveOutFilter:
    """Filter of sliding tyres: all sensors, large errors of the axle forces, and a common lost share of both drives."""
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


LACKS = 0.7  # least lateral acceleration that is lacking when tyres slide [m/s**2]


def ploughing(base: RollingFilter) -> RollingFilter:
    """Filter of a car with a sliding front axle, which does not turn as it is steered."""
    return replace(base, model_error=replace(base.model_error, lateral_jerk=5.0, steering=0.5, steering_share=0.0))


def skidding(base: RollingFilter) -> RollingFilter:
    """Filter of a car with all tyres sliding: any motion is possible, and no two wheels turn alike."""
    error = replace(
        base.model_error,
        jerk=20.0,
        lateral_jerk=20.0,
        steering=0.5,
        steering_share=0.0,
        slip=0.05,
        uneven=0.02,
        grade=5.0,
        bank=10.0,
    )
    return replace(base, model_error=error)


OF_SKIDDING = LowGrip(leads=-0.5, lacks=LACKS, largest=6.0, stays=1.0)
"""Criterion for sliding tyres of a car: a filter of sliding tyres explains the readings about as well as any other, and
force is lacking. Its numbers were chosen on 119 tests at the limit of seven virtual cars (seed 41), and on faults in a
virtual city drive (seed 1), which must still be declared."""
