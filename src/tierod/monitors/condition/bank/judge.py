"""The whole judge over the bank: what is at fault, of what kind, and how large."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Tree
from tierod.core.graph import Bank, JudgeSample, Verdict
from tierod.core.graph.maths import any_of, both, exp, maximum, sqrt, where
from tierod.monitors.condition.bank.decision import Decision, DecisionState
from tierod.monitors.condition.bank.diagnosis import Diagnosis
from tierod.monitors.condition.bank.lane import LeaveOutFilter
from tierod.monitors.condition.bank.leaving_out import leaving_out
from tierod.monitors.condition.bank.low_grip import sliding
from tierod.monitors.condition.bank.tuning import prices
from tierod.monitors.condition.bank.weighing import Limits, Weighing
from tierod.monitors.condition.kinds.catalogue import Kind
from tierod.monitors.condition.kinds.kind import KindOfFault
from tierod.monitors.condition.signals import ACTUATORS, SENSORS, Hypothesis, hypotheses


class Kinds(NamedTuple):
    """Kind and size of the fault of every sensor that is declared."""

    wheel_speed_rear_left: Kind
    wheel_speed_rear_right: Kind
    yaw_rate: Kind
    steering_wheel_angle: Kind
    steering_shaft_torque: Kind
    tie_rod_force: Kind


class Loss(NamedTuple):
    """What the actuators that are declared have lost.

    Args:
        share: of their torque, the same of both where two are, the mean over the last samples at which they had
            something to do; 0 while none is declared
        deviation: standard deviation of the share
    """

    share: Annotated[float, ""]
    deviation: Annotated[float, ""]


class Judgement(NamedTuple):
    """What is said of one sample.

    Args:
        decision: who is at fault, and what stands in for the sensors
        kinds: of faults of the sensors
        loss: of torque
    """

    decision: Diagnosis
    kinds: Kinds
    loss: Loss


class LossState(NamedTuple):
    """Weighted sums over the declared past [1/share^2]."""

    information: Any
    weighted: Any


@dataclass(frozen=True)
class ConditionJudge:
    """Decision between the hypotheses, and kind and size of what is declared.

    Args:
        decision: between the hypotheses
        kinds: one for each of `SENSORS`
        loss_time: over which a lost share of torque is averaged
    """

    decision: Decision
    kinds: tuple[KindOfFault, ...]
    loss_time: Annotated[float, "s"] = 2.0

    def feedback(self) -> Tree:
        """Lanes are told nothing."""
        return ()

    def init(self) -> tuple[DecisionState, tuple[Any, ...], LossState, tuple[float, ...]]:
        """Healthy."""
        return (
            self.decision.init(),
            tuple(kind.init() for kind in self.kinds),
            LossState(0.0, 0.0),
            (0.0,) * len(SENSORS),
        )

    def step(self, state: Any, sample: JudgeSample) -> tuple[Any, Verdict]:
        """One sample on."""
        decided, verdict = self.decision.step(state[0], sample, state[3])
        diagnosis = verdict.output
        foretold = [self._foretold(sample.lanes, diagnosis, name) for name in SENSORS]
        each = [
            kind.step(
                memory,
                KindOfFault.Sample(
                    getattr(sample.sample, name),
                    *told,
                    getattr(diagnosis.faulty, name),
                    getattr(diagnosis.recovering, name),
                ),
            )
            for kind, memory, told, name in zip(self.kinds, state[1], foretold, SENSORS, strict=True)
        ]
        losing, loss = self._loss(state[2], diagnosis)
        output = Judgement(diagnosis, Kinds(*(named for _, named in each)), loss)
        effects = tuple(named.effect for _, named in each)
        return (decided, tuple(memory for memory, _ in each), losing, effects), verdict._replace(output=output)

    def _foretold(self, lanes: Any, diagnosis: Diagnosis, name: str) -> tuple[Any, Any]:
        """What a sensor should read and the standard deviation, from what leaves it out beside all that is declared."""
        weighing, place = self.decision.weighing, SENSORS.index(name)
        prediction, deviation = diagnosis.prediction[place], diagnosis.deviation[place]
        beside: dict[int, list[int]] = {}
        for active, each in enumerate(weighing.hypotheses):
            number = weighing.number(*each.suspects, name)
            if number is not None:
                beside.setdefault(number, []).append(active)
        for number, several in beside.items():
            here = any_of(*(diagnosis.hypothesis == active for active in several))
            prediction = where(here, lanes[number].prediction[place], prediction)
            deviation = where(here, lanes[number].deviation[place], deviation)
        return prediction, deviation

    def _loss(self, state: LossState, diagnosis: Diagnosis) -> tuple[LossState, Loss]:
        """Mean of the lost share, weighted by what each sample knows of it; samples alike for a while count as one."""
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
        return LossState(information, weighted), Loss(share, deviation)


def condition_bank(
    base: LeaveOutFilter, limits: Limits, explanations: tuple[Hypothesis, ...] | None = None, sample_time: float = 0.01
) -> Bank:
    """The whole bank: one filter per hypothesis, one of sliding tyres, and the judge.

    Args:
        base: filter that suspects nobody
        limits: from calibration, for all but the healthy hypothesis
        explanations: hypotheses, healthy first; all of them if None
        sample_time: [s]
    """
    explanations = hypotheses() if explanations is None else explanations
    kinds = tuple(KindOfFault.of_sensor(name, base.plausible, sample_time) for name in SENSORS)
    lanes = (*(leaving_out(each, base) for each in explanations), sliding(base))
    weighing = Weighing(explanations, limits, sample_time, prices=prices(base.sensor_noise, base.plausible))
    return Bank(lanes, ConditionJudge(Decision(weighing), kinds))
