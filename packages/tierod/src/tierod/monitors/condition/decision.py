"""Decision on faulty sensors and actuators from the likelihoods of all filters of the bank."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree, rebuild, skeleton
from tierod.core.block import leaves as leaves_of
from tierod.core.graph import KEEP, JudgeSample, Verdict
from tierod.core.graph.maths import absolute, all_of, any_of, both, either, greatest_of, negated, present, where
from tierod.monitors.condition.low_grip import Lack, LowGrip, LowGripState
from tierod.monitors.condition.signals import (
    ALL_WHEELS,
    DRIVES,
    ELEMENTS,
    MOTORS,
    SENSORS,
    SLIDING,
    Elements,
    Hypothesis,
    Readings,
    readings_of,
)
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.monitors.condition.weighing import Ranking, Returning, Testability, Weighing, Weights, chosen


def selected_lane(
    hypotheses: Sequence[Hypothesis],
    likelihoods: Sequence[Scalar],
    active: Scalar,
    impossible: Scalar,
    slides: Scalar = 0.0,
) -> tuple[Scalar, Sequence[Scalar]]:
    """Lane that is used in a sample, and the lanes for which the sample is practically impossible.

    Normally this is the active lane. If the sample is practically impossible for it, the most likely lane is used that
    suspects at least the same elements. Lanes that suspect only actuators are excluded unless active, since the
    estimated loss of a fault-free actuator follows any disturbance.
    """
    best, top = active, chosen(likelihoods, active)
    own = top
    for number, value in enumerate(likelihoods):
        if _keeps_to_itself(hypotheses[number]):
            continue
        better = both(_contains(hypotheses, number, active), value > top)
        better = both(better, slides) if hypotheses[number] is SLIDING else better
        best, top = where(better, float(number), best), where(better, value, top)
    far_off: list[Scalar] = [value < top - impossible for value in likelihoods]
    return where(own < top - impossible, best, active), far_off


def best_pair_containing(
    hypotheses: Sequence[Hypothesis], likelihoods: Sequence[Scalar], impossible: Scalar
) -> list[Scalar]:
    """Most likely two-fault hypothesis that contains each single fault; 0 where the sample is impossible for it.

    If two sensors disagree, either may be faulty. A lane that continued from a lane which uses the other sensor would
    support the wrong hypothesis from then on; the pair uses neither.
    """
    top = greatest_of(*likelihoods)
    nearest = []
    for each in hypotheses:
        best: Scalar = 0.0
        highest = top - impossible
        for number, (other, value) in enumerate(zip(hypotheses, likelihoods, strict=True)):
            if each.suspects and each.agrees(other) and set(each.suspects) < set(other.suspects):
                better = value > highest
                best, highest = where(better, float(number), best), where(better, value, highest)
        nearest.append(best)
    return nearest


def adopted(
    hypotheses: Sequence[Hypothesis],
    source: Scalar,
    nearest: Sequence[Scalar],
    far_off: Sequence[Scalar],
    changed: Scalar,
    active: Scalar,
) -> tuple[Scalar, ...]:
    """Lane from whose state each lane continues; no lane adopts the lost torque of another actuator.

    A lane that suspects only actuators adopts no state until a fault is declared: it estimates the loss within some
    samples, and the state of a lane that leaves out sensors instead would lead it away from that estimate.
    """
    adopting = []
    for number, own in enumerate(hypotheses):
        taken = where(either(changed, nearest[number] == 0.0), source, nearest[number])
        foreign = any_of(0.0, *(taken == k for k, other in enumerate(hypotheses) if not own.agrees(other)))
        lost = both(far_off[number], negated(active == 0.0)) if _keeps_to_itself(own) else far_off[number]
        moves = all_of(either(changed, lost), negated(foreign), negated(taken == number))
        adopting.append(where(moves, taken, KEEP))
    return tuple(adopting)


def _keeps_to_itself(hypothesis: Hypothesis) -> bool:
    """Whether a hypothesis suspects only actuators, so that its lane adopts no state before a declaration."""
    return bool(hypothesis.actuators) and not hypothesis.sensors


def _contains(hypotheses: Sequence[Hypothesis], number: int, active: Scalar) -> Scalar:
    """Whether a hypothesis suspects at least the elements of the active one."""
    own = set(hypotheses[number].suspects)
    parts = [k for k, each in enumerate(hypotheses) if set(each.suspects) <= own]
    return any_of(0.0, *(active == part for part in parts))


class Diagnosis(NamedTuple):
    """Diagnosis at one sample."""

    hypothesis: Annotated[Scalar, ""]  # number of the active hypothesis, 0 for fault-free
    faulty: Elements  # declared elements
    candidates: Elements  # elements that may be faulty, if several hypotheses explain the samples almost equally well
    testable: Elements  # whether a total loss of each element would be detectable now
    spread: Elements
    recovering: Elements  # declared elements that have been consistent for the last samples
    gated: Readings  # readings of undeclared sensors that are outliers in this sample
    value: Readings
    prediction: Readings
    deviation: Readings
    torque_loss: Annotated[Scalar, ""]
    loss_deviation: Annotated[Scalar, ""]
    speed: Annotated[Scalar, "m/s"]  # speed, lateral_speed: speed components of the centre of gravity
    lateral_speed: Annotated[Scalar, "m/s"]
    best: Annotated[Scalar, ""]  # number of the hypothesis that explains the last samples best, the active one included
    lead: Annotated[Scalar, ""]  # its mean log-likelihood ratio per sample less that of its best rival [nat]
    low_grip: Annotated[Scalar, ""]  # whether tyres slide, so that no fault is declared


def gated(
    readings: Sequence[Scalar], estimate: LeaveOutFilter.Output, faulty: Elements, deviations: Scalar
) -> Readings:
    # Sensors come first in `faulty`: the shorter lists end before its actuators.
    known = zip(readings, estimate.prediction, estimate.deviation, faulty, strict=False)
    return Readings(
        *(
            all_of(
                negated(declared),
                present(reading),
                absolute(where(present(reading), reading, 0.0) - prediction) > deviations * deviation,
            )
            for reading, prediction, deviation, declared in known
        )
    )


def values_of(readings: Sequence[Scalar], estimate: LeaveOutFilter.Output, faulty: Elements, off: Readings) -> Readings:
    """Value of every sensor: its reading if it is trusted, else the estimate of the selected lane."""
    known = zip(readings, estimate.estimate, faulty, off, strict=False)
    return Readings(
        *(
            where(all_of(present(reading), negated(declared), negated(far)), reading, value)
            for reading, value, declared, far in known
        )
    )


class DecisionState(NamedTuple):
    """State of the decision."""

    weights: Weights  # smoothed log-likelihood ratios of all hypotheses against the active one
    active: Scalar  # number of the active hypothesis
    leading: Scalar  # number of the hypothesis that led in the previous sample; 0 for none
    led: Scalar  # number of consecutive samples of its lead; a sample with a small lead counts in part
    exceeded: Scalar  # number of consecutive samples in which any hypothesis exceeded its limit
    good: Elements  # number of samples for which each declared element has been consistent
    unread: Readings  # number of consecutive samples without a reading of each sensor
    slipping: LowGripState  # state of the check for sliding tyres
    cornered: Scalar  # number of samples for which tyres may still slide after hard cornering


class Grip(NamedTuple):
    """Grip of the tyres after a sample."""

    slipping: LowGripState  # slipping, cornered: see `DecisionState`, after this sample
    cornered: Scalar
    slides: Scalar  # whether tyres slide, according to the lanes of sliding tyres
    low: Scalar  # whether tyres slide, or may slide after hard cornering


@dataclass(frozen=True)
class SmallLeads:
    """Accumulation of leads below the gap for a fault of one wheel speed.

    In the filter that leaves out the other wheel of the axle, the estimated slip partly absorbs a slowly growing error,
    which then costs little likelihood per sample. The other axle, yaw rate and steering angle reveal it nevertheless;
    with fewer sensors a small lead is no evidence. Small leads count only while all sensors are read and no fault is
    declared.

    Chosen on faults of CommonRoad's multi-body car (seeds 1 to 3) and of a virtual compact car (seeds 1 to 4), of which
    none is named wrongly with 30 to 100 nat either, and on tests at the limit of grip (seeds 41 and 777).
    """

    least: Annotated[float, ""] = 0.3  # least lead of a sample to count [nat]
    # sum of consecutive leads that declares a fault, as `Decision.samples` leads by the gap do [nat]
    enough: Annotated[float, ""] = 50.0
    # least lead over the filters of sliding tyres for a sample to count [nat]; sliding wheels turn unevenly. Without
    # such a filter no sample counts
    over_sliding: Annotated[float, ""] = 3.0


@dataclass(frozen=True)
class Decision:
    """Declare faulty elements from the likelihoods of all hypotheses, and withdraw those that have recovered.

    A hypothesis is declared when its smoothed log-likelihood ratio against the active one exceeds its limit and it
    leads all others by a gap, for some consecutive samples; without the gap, all hypotheses close to the best are
    candidates. All lanes then continue from the state of the declared one. Before that, a lane for which a sample is
    practically impossible continues from the state of the lane that explains the sample best: an outlying reading is
    gated at once, and a faulty sensor does not disturb the lanes that use it.

    Args:
        samples: number of consecutive samples for which a hypothesis must lead
        samples_of_actuators: the same for a hypothesis with an actuator; motors are isolated by a changing split of
            their torque, and such a change takes some 0.1 s
        samples_of_both_motors: the same for both steering motors; a loss of one alone looks like a loss of both until
            the split of their torque has changed, every 0.12 s
        impossible: log-likelihood ratio of one sample to the best hypothesis at which a lane is corrected [nat]; twice
            the cost of leaving out a sensor
        gate: number of standard deviations beyond which a single reading is gated
        low_grip: decides whether the tyres slide, from the lanes of sliding tyres, which come last, if there are any
        small_leads: accumulation of leads below the gap; None counts leads by the gap only

    Source: Li, Frey, Gauterin, sections 3 and 4, replaced: their rules isolate no sensor for most faults.
    """

    weighing: Weighing
    samples: Annotated[float, ""] = 3.0
    samples_of_actuators: Annotated[float, ""] = 10.0
    samples_of_both_motors: Annotated[float, ""] = 20.0
    impossible: Annotated[float, ""] = 12.0
    gate: Annotated[float, ""] = 6.0
    low_grip: LowGrip = field(default_factory=LowGrip)
    testability: Testability = field(default_factory=Testability)
    returning: Returning = field(default_factory=Returning)
    small_leads: SmallLeads | None = None

    def feedback(self) -> Tree:
        return ()

    def init(self) -> DecisionState:
        none = Elements(*(0.0,) * len(ELEMENTS)), Readings(*(0.0,) * len(SENSORS))
        return DecisionState(self.weighing.init(), 0.0, 0.0, 0.0, 0.0, *none, self.low_grip.init(), 0.0)

    def step(self, state: DecisionState, sample: JudgeSample, effects: Tree = None) -> tuple[DecisionState, Verdict]:
        lanes, readings = sample.lanes, readings_of(sample.sample)
        likelihoods = [lane.log_likelihood for lane in lanes]
        grip = self._grip(state, sample, likelihoods)
        count = len(self.weighing.hypotheses)
        everyone = (*self.weighing.hypotheses, *(SLIDING,) * (len(lanes) - count))
        source, far_off = selected_lane(everyone, likelihoods, state.active, self.impossible, grip.slides)
        seen = _selected(lanes, source)
        suspected = self._elements_of(state.active)
        unread = [where(present(each), 0.0, count + 1.0) for each, count in zip(readings, state.unread, strict=True)]
        open_, widening = self.testability.open(self.weighing, unread, suspected)
        follows = both(seen.moving, negated(grip.low))
        weights, ranking = self._weighed(state, likelihoods, seen, follows, open_, widening)
        good = self.returning.good(state.good, suspected, readings, seen, effects)
        kept = self.returning.after(self.weighing, state.active, suspected, good)

        small = self._small_lead_counts(state, ranking, likelihoods, both(follows, seen.driven), unread, grip)
        # While tyres slide all lanes with gripping tyres are wrong, so that their leads must not add up.
        led, exceeded = (where(grip.slides, 0.0, count) for count in self._counted(state, ranking, small))
        active = where(self._declares(ranking, led), ranking.best, kept)
        changed = negated(active == state.active)
        faulty = self._elements_of(active)
        stays = [both(each, negated(changed)) for each in faulty]
        after = DecisionState(
            self.weighing.restarted(weights, active, changed),
            active,
            where(changed, 0.0, ranking.best),
            where(changed, 0.0, led),
            where(changed, 0.0, exceeded),
            Elements(*(where(each, count, 0.0) for each, count in zip(stays, good, strict=True))),
            Readings(*unread),
            grip.slipping,
            grip.cornered,
        )
        off = gated(readings, seen, faulty, self.gate)
        declarable = [both(follows, each) for each in open_]
        unsure = both(exceeded >= self.samples, negated(changed))
        output = Diagnosis(
            active,
            faulty,
            self._candidates(ranking.rivals, unsure, faulty),
            *self.testability.testable(self.weighing, lanes, suspected, seen, declarable),
            self.returning.recovering(faulty, good, self.weighing.sample_time),
            off,
            values_of(readings, seen, faulty, off),
            *(seen.prediction, seen.deviation, seen.torque_loss, seen.loss_deviation, seen.speed, seen.lateral_speed),
            where(ranking.exceeding, ranking.best, active),
            where(ranking.exceeding, ranking.lead, 0.0),
            grip.low,
        )
        nearest = best_pair_containing(everyone, likelihoods, self.impossible)
        taken = where(changed, active, source)
        return after, Verdict(output, adopted(everyone, taken, nearest, far_off, changed, active))

    def _grip(self, state: DecisionState, sample: JudgeSample, likelihoods: Sequence[Scalar]) -> Grip:
        """Whether the tyres slide, and whether they may slide by the lateral acceleration."""
        slipping, slides, lacks = self._slides(state, sample.lanes, likelihoods)
        across = sample.sample.lateral_acceleration
        # A car may lack this sensor: its filter then gives speed times yaw rate, that of the whole vehicle gives 0.
        across = where(present(across), across, sample.lanes[-1].turning)
        cornered = self.testability.cornered(state.cornered, across, lacks, self.weighing.sample_time)
        return Grip(slipping, cornered, slides, either(slides, cornered > 0.5))

    def _slides(
        self, state: DecisionState, lanes: Sequence[LeaveOutFilter.Output], likelihoods: Sequence[Scalar]
    ) -> tuple[LowGripState, Scalar, Scalar]:
        """Whether the tyres slide, and whether an axle lacks lateral force, from the lanes of sliding tyres, if any.

        While a fault is declared, no sliding is reported, since these lanes still use the faulty element.
        """
        count = len(self.weighing.hypotheses)
        if len(lanes) == count:
            return state.slipping, 0.0, 0.0
        own = lanes[-1]
        lack = Lack(greatest_of(*(lane.lack for lane in lanes[count:])), own.lack_along, own.given_along)
        numbers = [number for name in DRIVES if (number := self.weighing.number(name)) is not None]
        after, slides = self.low_grip.after(
            state.slipping,
            greatest_of(*likelihoods[count:]),
            likelihoods[:count],
            [likelihoods[number] for number in numbers],
            lack,
            own.moving,
            self.weighing.sample_time,
        )
        return after, both(slides, state.active == 0.0), lack.across > self.low_grip.lacks

    def _weighed(
        self,
        state: DecisionState,
        likelihoods: Sequence[Scalar],
        seen: LeaveOutFilter.Output,
        follows: Scalar,
        open_: Sequence[Scalar],
        widening: Scalar,
    ) -> tuple[Weights, Ranking]:
        counting = [
            both(*each) for each in zip(self.testability.counting(self.weighing, seen, follows), open_, strict=True)
        ]
        weighed = likelihoods[: len(self.weighing.hypotheses)]
        weights = self.weighing.smoothed(state.weights, weighed, state.active, counting)
        return weights, self.weighing.ranking(weights, state.active, widening, open_)

    def _counted(self, state: DecisionState, ranking: Ranking, small: Scalar) -> tuple[Scalar, Scalar]:
        """Number of consecutive samples of the best hypothesis' lead, and of any hypothesis beyond its limit."""
        leads: Scalar = ranking.lead > self.weighing.limits.gap
        counts: Scalar = 1.0
        if self.small_leads is not None:
            counts = where(leads, 1.0, ranking.lead * self.samples / self.small_leads.enough)
            leads = either(leads, both(ranking.lead > self.small_leads.least, small))
        led = where(ranking.best == state.leading, state.led, 0.0) + counts
        led = where(both(ranking.exceeding, leads), led, 0.0)
        return led, where(ranking.exceeding, state.exceeded + 1.0, 0.0)

    def _small_lead_counts(
        self,
        state: DecisionState,
        ranking: Ranking,
        likelihoods: Sequence[Scalar],
        shows: Scalar,
        unread: Sequence[Scalar],
        grip: Grip,
    ) -> Scalar:
        """Whether a small lead counts in this sample, which must itself support the best hypothesis."""
        if self.small_leads is None:
            return 0.0
        most = self.testability.missing / self.weighing.sample_time
        wheels = [number for name in ALL_WHEELS if (number := self.weighing.number(name)) is not None]
        return all_of(
            shows,
            state.active == 0.0,
            chosen(likelihoods, ranking.best) > likelihoods[0],
            grip.slipping.lead < -self.small_leads.over_sliding,
            any_of(0.0, *(ranking.best == number for number in wheels)),
            *(unread[SENSORS.index(name)] <= most for name in self.testability.judged),
        )

    def _declares(self, ranking: Ranking, led: Scalar) -> Scalar:
        patient = any_of(0.0, *(ranking.best == k for k, each in enumerate(self.weighing.hypotheses) if each.actuators))
        needed = where(patient, self.samples_of_actuators, self.samples)
        motors = self.weighing.number(*MOTORS)
        if motors is not None:
            needed = where(ranking.best == motors, self.samples_of_both_motors, needed)
        return led >= needed

    def _elements_of(self, number: Scalar) -> Elements:
        """Elements that a hypothesis suspects, by a number that is known at run time only."""
        return Elements(*(any_of(0.0, *(number == k for k in self.weighing.naming(name))) for name in ELEMENTS))

    def _candidates(self, rivals: Sequence[Scalar], unsure: Scalar, faulty: Elements) -> Elements:
        return Elements(
            *(
                all_of(unsure, negated(known), any_of(0.0, *(rivals[k] for k in self.weighing.naming(name))))
                for name, known in zip(ELEMENTS, faulty, strict=True)
            )
        )


def _selected(lanes: Sequence[LeaveOutFilter.Output], number: Scalar) -> LeaveOutFilter.Output:
    """Output of one lane, by a number that is known at run time only."""
    columns = zip(*([leaf for _, leaf in leaves_of(lane)] for lane in lanes), strict=True)
    picked: LeaveOutFilter.Output = rebuild(
        skeleton(LeaveOutFilter.Output), [chosen(column, number) for column in columns]
    )
    return picked
