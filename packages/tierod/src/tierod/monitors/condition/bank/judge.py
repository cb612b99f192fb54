"""Judge of the bank: declares faulty elements, estimates kind and magnitude of their faults, and reacts to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.findings import Status
from tierod.core.graph import JudgeSample, Verdict
from tierod.core.graph.maths import all_of, any_of, both, exp, hypot, maximum, minimum, negated, present, sqrt, where
from tierod.core.statement import Statement, code_of
from tierod.monitors.condition.bank.decision import Decision, DecisionState
from tierod.monitors.condition.bank.diagnosis import Diagnosis
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.kinds.catalogue import LOST_TORQUE, NOISE, Kind, KindState
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.reaction import FaultReaction, Judged, ReactionState
from tierod.monitors.condition.signals import ACTUATORS, ELEMENTS, OF_AUTOMATED, SENSORS, Elements, Statements
from tierod.monitors.condition.spans import Residual, SpanOfFault, Spans

LARGEST_LEAD = 20.0
"""Upper bound of the reported lead [nat], which is unbounded while there is no rival."""


class LostTorque(NamedTuple):
    """Lost share of the torque of the declared actuators, the same for both if there are two.

    Args:
        share: mean over recent samples, weighted by their information; 0 while no actuator is declared
        deviation: standard deviation of the share
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


@dataclass(frozen=True)
class ConditionJudge:
    """Decision between the hypotheses, kind and magnitude of declared faults, and the reaction to them.

    Args:
        decision: decision between the hypotheses
        kinds: classifiers of faults, one for each of `judged`
        judged: sensors that the vehicle has
        reaction: substitutes of sensors, and trouble codes
        spans: onset and end of every fault
        loss_time: time constant of the mean of a lost share of torque
    """

    decision: Decision
    kinds: tuple[KindOfFault, ...]
    reaction: FaultReaction
    judged: tuple[str, ...] = OF_AUTOMATED
    spans: SpanOfFault = field(default_factory=SpanOfFault)
    loss_time: Annotated[float, "s"] = 2.0

    def feedback(self) -> Tree:
        """No feedback to the lanes."""
        return ()

    def init(self) -> JudgeState:
        """State before the first sample: fault-free."""
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
        """Process one sample."""
        decided, verdict = self.decision.step(state.decision, sample, state.effects)
        diagnosis: Diagnosis = verdict.output
        predicted = {name: self._predicted(sample.lanes, diagnosis, SENSORS.index(name)) for name in self.judged}
        spans, dated = state.spans.followed_by(
            self._statements(diagnosis), self._residuals(state, predicted, sample, diagnosis), self.spans
        )
        supports = spans.supports
        parts = zip(self.kinds, self.judged, state.kinds, strict=True)
        named = [
            self._kind(*each, (*predicted[each[1]], getattr(supports, each[1])), sample, diagnosis) for each in parts
        ]
        found = {name: kind for name, (_, kind) in zip(self.judged, named, strict=True)}
        kinds = [found.get(name, Kind(0.0, 0.0, 0.0, 0.0)) for name in SENSORS]
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
            tuple(memory for memory, _ in named),
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
        """Statements with kind and magnitude of every declared fault."""
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

    def _kind(
        self,
        kind: KindOfFault,
        name: str,
        memory: KindState,
        predicted: tuple[Scalar, Scalar, Scalar],
        sample: JudgeSample,
        diagnosis: Diagnosis,
    ) -> tuple[KindState, Kind]:
        """Classification of the fault of one sensor."""
        place = SENSORS.index(name)
        reading = getattr(sample.sample, name)
        prediction, deviation, supports = predicted
        declared, recovering = diagnosis.faulty[place], diagnosis.recovering[place]
        return kind.step(
            memory,
            KindOfFault.Sample(reading, prediction, deviation, declared, recovering, supports),
        )

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
