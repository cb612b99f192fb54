"""Judge of the bank: declares faulty elements, dates their faults, estimates kind and magnitude, and reacts to them.

A fault is declared when its evidence is sure, which may be long after its onset, and is withdrawn some time after its
end. Its span comes from the residual of each element, in standard deviations: the log-likelihood ratio of "faulty" to
"fault-free" is summed, never below zero (Page, Continuous inspection schemes, Biometrika 41, 1954). The sum was last
zero at the likeliest onset, and is largest at the likeliest end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.findings import Status
from tierod.core.graph import JudgeSample, Verdict
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    either,
    exp,
    hypot,
    limit,
    log,
    maximum,
    minimum,
    negated,
    present,
    sqrt,
    where,
)
from tierod.core.statuses import Statement, code_of
from tierod.monitors import decision as reported
from tierod.monitors.condition.decision import Decision, DecisionState, Diagnosis
from tierod.monitors.condition.kinds import LOST_TORQUE, NOISE, Kind, KindOfFault, KindState
from tierod.monitors.condition.reaction import EVIDENCE, FaultReaction, Judged, ReactionState
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, OF_AUTOMATED, SENSORS, Elements, Statements
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.monitors.decision import decides
from tierod.physics.friction import share_reached


class Residual(NamedTuple):
    """Residual of one element at one sample."""

    size: Scalar  # residual in standard deviations
    known: Scalar  # whether there is one
    # residual that the declared fault is estimated to cause, in standard deviations; 0 where it is not known
    effect: Scalar = 0.0
    # standard deviation of the noise that it is estimated to be, in the same unit; 0 for another kind
    noise: Scalar = 0.0
    reading: Scalar | None = None  # reading of the sensor; None for an actuator


class Evidence(NamedTuple):
    """Evidence of a fault of one element."""

    amount: Scalar  # sum of the log-likelihood ratios since it was last zero [nat]
    began: Scalar  # time at which the sum began to grow [s]
    largest: Scalar  # largest sum since then [nat]
    supported: Scalar  # time of the sample with the largest sum [s]; negative without evidence
    last: Scalar  # last reading
    repeated: Scalar  # time since when it repeats one value [s]
    # 1 where this sample supported a fault, 0 where it did not, -1 where evidence is absent or begins anew
    supports: Scalar
    level: Scalar  # recent mean size of the residuals, and its largest value since the evidence began
    highest: Scalar
    jumped: Scalar  # number of consecutive residuals far beyond that


@dataclass(frozen=True)
class SpanOfFault:
    """Onset and end of a fault from the residuals of an element.

    Chosen on drives of seeds 1 and 11 of virtual demonstrators and cars, and judged on others.
    """

    sample_time: Annotated[float, "s"] = 0.01  # sampling interval
    # standard deviation of the residual of a faulty element, in those of a fault-free one; a residual beyond 1.9 is
    # then evidence for a fault
    broader: Annotated[float, ""] = 6.0
    # bound of the log-likelihood ratio of a sample [nat], so that a few outliers do not outweigh a second
    most: Annotated[float, ""] = 2.8
    # time of consistent residuals after which undeclared evidence is forgotten, and a declared fault has ended; a fault
    # may be invisible for a second, as a reading stuck near the truth
    forgets: Annotated[float, "s"] = 1.7
    still: Annotated[float, "s"] = 0.1  # least time of equal readings of a sensor that is stuck
    # longest time for which equal readings count before the first residual that contradicts them
    before: Annotated[float, "s"] = 10.0
    recent: Annotated[float, "s"] = 0.1  # time constant of the recent mean size
    # jump, times: residuals beyond `times` that mean and `jump` standard deviations more begin anew: before them the
    # prediction was wrong, as in a bend
    jump: Annotated[float, ""] = 4.0
    times: Annotated[float, ""] = 2.0
    jumps: Annotated[float, ""] = 3.0  # number of consecutive ones that do
    lasting: bool = False  # whether evidence outlasts the declaration, which rules withdraw while a symptom is missing

    @property
    def forgotten(self) -> Scalar:
        """Evidence that is lost in the time of `forgets` [nat]."""
        return self.forgets / self.sample_time * log(self.broader)

    def after(
        self, before: Evidence, time: Scalar, residual: Residual, declared: Scalar, was_declared: Scalar
    ) -> Evidence:
        """Evidence after one sample."""
        known, ratio = residual.known, self._ratio(residual, declared)
        bound = self.forgotten
        amount = maximum(before.amount + where(known, ratio, 0.0), 0.0)
        amount = where(declared, amount, minimum(amount, bound))
        largest = where(declared, before.largest, minimum(before.largest, bound))
        grows = all_of(known, ratio > 0.0, amount >= largest)
        last, repeated = self._repeated(before, time, residual.reading)
        stands = both(grows, time - repeated >= self.still)
        earlier = maximum(repeated, time - self.before)
        none = both(negated(declared), amount <= 0.0)
        if not self.lasting:
            none = either(none, both(was_declared, negated(declared)))
        size = where(known, absolute(residual.size), before.level)
        jumped = where(size > self.times * before.highest + self.jump, before.jumped + 1.0, 0.0)
        anew = both(negated(declared), jumped >= self.jumps)
        level = before.level + share_reached(self.sample_time / self.recent) * (size - before.level)
        level = where(jumped > 0.0, before.level, level)
        first = time - (self.jumps - 1.0) * self.sample_time
        began = where(anew, maximum(first, before.began), before.began)
        return Evidence(
            where(none, 0.0, amount),
            where(none, time + self.sample_time, where(stands, minimum(began, earlier), began)),
            where(none, 0.0, where(grows, amount, largest)),
            where(none, -1.0, where(grows, time, before.supported)),
            last,
            repeated,
            where(either(none, anew), -1.0, where(grows, 1.0, 0.0)),
            where(none, 0.0, where(anew, size, level)),
            where(none, 0.0, where(anew, size, maximum(before.highest, level))),
            where(either(none, anew), 0.0, jumped),
        )

    def _ratio(self, residual: Residual, declared: Scalar) -> Scalar:
        """Log-likelihood ratio of "faulty" to "fault-free" for one residual.

        A declared fault with a known effect or noise is compared with none, so that a small one ends with its effect;
        any other is a residual of larger spread.
        """
        size, effect = where(residual.known, residual.size, 0.0), where(residual.known, residual.effect, 0.0)
        wide = where(both(declared, residual.noise > 0.0), hypot(1.0, residual.noise), self.broader)
        spread = 0.5 * (1.0 - 1.0 / (wide * wide)) * size * size - log(wide)
        shift = effect * (size - 0.5 * effect)
        ratio = where(both(declared, absolute(effect) > 0.0), shift, spread)
        return limit(ratio, -self.most, self.most)

    @staticmethod
    def _repeated(before: Evidence, time: Scalar, reading: Scalar | None) -> tuple[Scalar, Scalar]:
        """Last reading, and time since when it repeats; an actuator never stands still."""
        if reading is None:
            return before.last, time
        read = present(reading)
        equal = either(negated(read), reading == before.last)
        return where(read, reading, before.last), where(equal, before.repeated, time)


class Spans(NamedTuple):
    """Status of every element at the previous sample, since when it holds, and the evidence for a fault."""

    time: Scalar  # time since the start of the run [s]
    status: Elements  # codes of the statuses; -1 before the first sample
    began: Elements  # time at which each status began [s]; negative if it holds since the start
    evidence: tuple[Evidence, ...]  # evidence of a fault of each element

    @classmethod
    def initial(cls) -> Spans:
        """State before the first sample."""
        unknown = Elements(*(-1.0,) * len(ELEMENTS))
        nothing = Evidence(*(0.0,) * len(Evidence._fields))._replace(supported=-1.0, supports=-1.0)
        return cls(0.0, unknown, unknown, (nothing,) * len(ELEMENTS))

    @property
    def supported(self) -> Elements:
        """Time until which the residuals supported a fault of each element [s]; negative without evidence for one."""
        return Elements(*(each.supported for each in self.evidence))

    def ended(self, of: SpanOfFault) -> Elements:
        """Whether the residuals have contradicted each declared fault since then."""
        declared = [each == code_of(Status.FAULT) for each in self.status]
        lost = [each.largest - each.amount > of.forgotten for each in self.evidence]
        return Elements(*(where(both(*each), 1.0, 0.0) for each in zip(declared, lost, strict=True)))

    @property
    def supports(self) -> Elements:
        """Whether the last sample supported a fault of each element, see `Evidence`."""
        return Elements(*(each.supports for each in self.evidence))

    def followed_by(
        self, statements: Statements, residuals: Mapping[str, Residual], of: SpanOfFault
    ) -> tuple[Spans, Statements]:
        """State after one sample, and the dated statements.

        The time of a fault, or of a doubt, is that of the first evidence for it; of another status, that of its change.
        """
        began, evidence, dated = [], [], []
        places = zip(ELEMENTS, statements, self.status, self.began, self.evidence, strict=True)
        for name, each, status, start, known in places:
            began.append(where(either(each.status == status, status < 0.0), start, self.time))
            declared, was_declared = (code == code_of(Status.FAULT) for code in (each.status, status))
            shown = residuals.get(name)
            evidence.append(
                known._replace(began=self.time, supported=where(declared, self.time, -1.0))
                if shown is None
                else of.after(known, self.time, shown, declared, was_declared)
            )
            suspected = either(declared, each.status == code_of(Status.SUSPECT))
            since = where(suspected, minimum(began[-1], evidence[-1].began), began[-1])
            dated.append(each._replace(since=since))
        after = Spans(
            self.time + of.sample_time,
            Elements(*(each.status for each in statements)),
            Elements(*began),
            tuple(evidence),
        )
        return after, Statements(*dated)


LARGEST_LEAD = 20.0  # upper bound of the reported lead [nat], which is unbounded while there is no rival


class LostTorque(NamedTuple):
    """Lost share of the torque of the declared actuators, the same for both if there are two; 0 while none is declared.

    It is the mean over recent samples, weighted by their information.
    """

    share: Annotated[Scalar, ""]
    deviation: Annotated[Scalar, ""]


class LossState(NamedTuple):
    """Sums of the information on the lost share, and of the share weighted by it, since the declaration [1/share^2]."""

    information: Scalar
    weighted: Scalar


class JudgeState(NamedTuple):
    """States of the parts of the judge, and the change that the fault of each sensor adds to its reading."""

    decision: DecisionState
    kinds: tuple[KindState, ...]
    loss: LossState
    lost: LostTorque
    effects: tuple[Scalar, ...]
    spans: Spans
    reaction: ReactionState


BANK_DECIDES = "fault of a sensor or actuator"  # name of the decision that declares faults

DECLARES = reported.Decision(
    name=BANK_DECIDES,
    distance="log-likelihood ratio, per sample, of the filter without the suspect, means over 0.05 and 0.5 s",
    rule=reported.OwnRule(
        "above the vehicle file's limits and 2 nat above all others, 3 samples in a row, 10 for an actuator, 20 "
        "for both steering motors",
        {
            "samples": 3.0,
            "samples_of_actuators": 10.0,
            "samples_of_both_motors": 20.0,
            "impossible": 12.0,
            "gate": 6.0,
            "weighing.limits.gap": 2.0,
            "weighing.limits.margin": 1.0,
        },
    ),
    place="",
    mean_time_between_false_alarms=1000.0,
    demonstrated=reported.Demonstrated(3.0),
    source="tierod.monitors.condition.limits, for a vehicle that 'tierod identify thresholds' has calibrated",
    statistic=EVIDENCE,
    levels=(2.0,),
)


@dataclass(frozen=True)
class ConditionJudge:
    """Decision between the hypotheses, kind and magnitude of declared faults, and the reaction to them."""

    decision: Decision = field(metadata=decides(DECLARES))  # decision between the hypotheses
    kinds: tuple[KindOfFault, ...]  # classifiers of faults, one for each of `judged`
    reaction: FaultReaction  # substitutes of sensors, and trouble codes
    judged: tuple[str, ...] = OF_AUTOMATED  # sensors that the vehicle has
    spans: SpanOfFault = field(default_factory=SpanOfFault)  # onset and end of every fault
    loss_time: Annotated[float, "s"] = 2.0  # time constant of the mean of a lost share of torque

    def feedback(self) -> Tree:
        return ()

    def init(self) -> JudgeState:
        return JudgeState(
            self.decision.init(),
            tuple(kind.init() for kind in self.kinds),
            LossState(0.0, 0.0),
            LostTorque(0.0, 0.0),
            (0.0,) * len(SENSORS),
            Spans.initial(),
            self.reaction.init(),
        )

    def step(self, state: JudgeState, sample: JudgeSample) -> tuple[JudgeState, Verdict]:
        decided, verdict = self.decision.step(state.decision, sample, state.effects)
        diagnosis: Diagnosis = verdict.output
        predicted = {name: self._predicted(sample.lanes, diagnosis, SENSORS.index(name)) for name in self.judged}
        spans, dated = state.spans.followed_by(
            self._statements(diagnosis), self._residuals(state, predicted, sample, diagnosis), self.spans
        )
        supports = spans.supports
        named: dict[str, tuple[KindState, Kind]] = {}
        for name, kind, memory in zip(self.judged, self.kinds, state.kinds, strict=True):
            place, reading = SENSORS.index(name), getattr(sample.sample, name)
            flags = diagnosis.faulty[place], diagnosis.recovering[place], getattr(supports, name)
            named[name] = kind.step(memory, KindOfFault.Sample(reading, *predicted[name], *flags))
        kinds = [named[name][1] if name in named else Kind(0.0, 0.0, 0.0, 0.0) for name in SENSORS]
        losing, loss = self._loss(state.loss, diagnosis)
        lost = self._lost(state.lost, loss, supports)
        statements = self._with_kinds(dated, diagnosis, kinds, lost)
        judged = Judged(
            statements,
            diagnosis.testable,
            diagnosis.spread,
            diagnosis.value,
            diagnosis.gated,
            minimum(diagnosis.lead, LARGEST_LEAD),
            diagnosis.low_grip,
            spans.supported,
            spans.ended(self.spans),
        )
        reacting, output = self.reaction.step(state.reaction, sample.sample, judged)
        after = JudgeState(
            decided,
            tuple(memory for memory, _ in named.values()),
            losing,
            lost,
            tuple(kind.effect for kind in kinds),
            spans,
            reacting,
        )
        return after, verdict._replace(output=output)

    def _statements(self, diagnosis: Diagnosis) -> Statements:
        """Status and evidence of every element; times are added by `Spans`, kinds by `_with_kinds`."""
        weighing = self.decision.weighing
        made: list[Statement] = []
        for name, faulty, candidate, testable in zip(
            ELEMENTS, diagnosis.faulty, diagnosis.candidates, diagnosis.testable, strict=True
        ):
            best = any_of(
                0.0, *(diagnosis.best == k for k, each in enumerate(weighing.hypotheses) if name in each.suspects)
            )
            lead = where(best, minimum(diagnosis.lead, LARGEST_LEAD) / weighing.limits.gap, 0.0)
            # After its declaration a hypothesis is the reference of all ratios and has no lead, hence the 1 below.
            quiet = where(testable, code_of(Status.HEALTHY), code_of(Status.NOT_TESTABLE))
            status = where(faulty, code_of(Status.FAULT), where(candidate, code_of(Status.SUSPECT), quiet))
            made.append(Statement(status, 0.0, 0.0, 0.0, 0.0, where(faulty, maximum(lead, 1.0), lead)))
        return Statements(*made)

    def _with_kinds(
        self, statements: Statements, diagnosis: Diagnosis, kinds: Sequence[Kind], lost: LostTorque
    ) -> Statements:
        # A filter with too little information on the motor may estimate a loss of more than all torque.
        torque = Kind(LOST_TORQUE, minimum(lost.share, 1.0), lost.deviation, 0.0)
        named = (*kinds, *(torque for _ in ACTUATORS))
        return Statements(
            *(
                each._replace(
                    kind=where(faulty, kind.kind, 0.0),
                    magnitude=where(faulty, kind.magnitude, 0.0),
                    deviation=where(faulty, kind.deviation, 0.0),
                )
                for each, faulty, kind in zip(statements, diagnosis.faulty, named, strict=True)
            )
        )

    @staticmethod
    def _lost(before: LostTorque, now: LostTorque, supports: Elements) -> LostTorque:
        """Lost share at the last sample that supported a loss; torque after its end does not count."""
        flags = [getattr(supports, name) for name in ACTUATORS]
        stays = all_of(before.deviation > 0.0, now.deviation > 0.0, *(each < 0.5 for each in flags))
        return LostTorque(*(where(stays, old, new) for old, new in zip(before, now, strict=True)))

    def _residuals(
        self,
        state: JudgeState,
        predicted: Mapping[str, tuple[Scalar, Scalar]],
        sample: JudgeSample,
        diagnosis: Diagnosis,
    ) -> dict[str, Residual]:
        """Residual of every element, by the lane without it; none while tyres slide, which all lanes misjudge."""
        found: dict[str, Residual] = {}
        grips = negated(diagnosis.low_grip)
        for name, kind, memory in zip(self.judged, self.kinds, state.kinds, strict=True):
            reading, (prediction, deviation) = getattr(sample.sample, name), predicted[name]
            spread, effect = hypot(deviation, kind.unknown), state.effects[SENSORS.index(name)]
            # A reading that is right again has no finite effect.
            shift, noisy = where(present(effect), effect, 0.0) / spread, memory.likeliest == NOISE
            found[name] = Residual(
                (reading - prediction) / spread,
                both(grips, present(reading)),
                where(noisy, 0.0, shift),
                where(noisy, shift, 0.0),
                reading,
            )
        for name in ACTUATORS:
            number = self.decision.weighing.number(name)
            if number is not None:
                lane = sample.lanes[number]
                lost = lane.torque_loss / maximum(lane.loss_deviation, 1e-3)
                found[name] = Residual(lost, grips)
        return found

    def _predicted(
        self, lanes: Sequence[LeaveOutFilter.Output], diagnosis: Diagnosis, place: int
    ) -> tuple[Scalar, Scalar]:
        """Prediction of a reading and its standard deviation, by the lane without the sensor and all declared ones."""
        weighing = self.decision.weighing
        prediction, deviation = diagnosis.prediction[place], diagnosis.deviation[place]
        beside: dict[int, list[int]] = {}
        for active, each in enumerate(weighing.hypotheses):
            number = weighing.number(*each.suspects, SENSORS[place])
            if number is not None:
                beside.setdefault(number, []).append(active)
        for number, several in beside.items():
            here = any_of(*(diagnosis.hypothesis == active for active in several))
            prediction = where(here, lanes[number].prediction[place], prediction)
            deviation = where(here, lanes[number].deviation[place], deviation)
        return prediction, deviation

    def _loss(self, state: LossState, diagnosis: Diagnosis) -> tuple[LossState, LostTorque]:
        """Mean of the lost share, weighted by information; autocorrelated samples count as one."""
        declared = any_of(0.0, *(getattr(diagnosis.faulty, name) for name in ACTUATORS))
        step = self.decision.weighing.sample_time
        kept = exp(-step / self.loss_time)
        spread = maximum(diagnosis.loss_deviation, 1e-3)
        weight = 1.0 / (spread * spread)
        information = where(declared, kept * state.information + weight, 0.0)
        weighted = where(declared, kept * state.weighted + weight * diagnosis.torque_loss, 0.0)
        known = both(declared, information > 0.0)
        alike = maximum(self.kinds[0].alike / step, 1.0)
        share = where(known, weighted / maximum(information, 1e-9), 0.0)
        deviation = where(known, sqrt(alike / maximum(information, 1e-9)), 0.0)
        return LossState(information, weighted), LostTorque(share, deviation)
