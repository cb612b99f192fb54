"""An estimator of the paper with the running verdict of the default monitor, so that all are judged alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from tierod.core.block import rebuild
from tierod.core.graph import Memory
from tierod.core.graph.maths import all_of, present, where
from tierod.monitors.friction.refined import RefinedFrictionMonitor
from tierod.monitors.friction.refined_signals import FrictionEstimate
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.verdict import FrictionVerdict, VerdictOutput
from tierod.monitors.friction.verdict_state import VerdictSample


@dataclass(frozen=True)
class JudgedEstimator:
    """Estimate the friction as the paper does, and judge it as the default monitor does.

    Args:
        filter: the refined monitor, or its unscented variant
        verdict: the judge
        name: as in findings and in stored levels

    The paper's estimators know no build-up of friction; the verdict gets the direction of motion in its place, and full
    excitation.
    """

    filter: RefinedFrictionMonitor
    verdict: FrictionVerdict
    name: str = "friction, judged estimator"

    class State(NamedTuple):
        """Of estimator and judge."""

        filter: Any
        verdict: Any

    class Output(NamedTuple):
        """Of estimator and judge, and what the judge saw."""

        estimate: FrictionEstimate
        seen: VerdictSample
        verdict: VerdictOutput

    @property
    def Sample(self) -> type:
        """That of the estimator."""
        return self.filter.Sample

    def init(self) -> State:
        """Nothing learnt yet."""
        return self.State(self.filter.init(), self.verdict.init())

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        filter_state, estimate = self.filter.step(state.filter, sample)
        speed = getattr(sample, "vehicle_speed", None)
        conditions = self.filter.gate.conditions(
            sample.driver_torque, sample.motor_torque, sample.steering_wheel_rate, speed
        )
        complete = all_of(*(present(value) for value in sample))
        seen = VerdictSample(
            friction_torque=estimate.friction_torque,
            friction_deviation=estimate.friction_deviation,
            misfit=1.0,
            enabled=estimate.enabled,
            hands_on=conditions.hands_on,
            same_direction=conditions.same_direction,
            moving=conditions.moving,
            rolling=conditions.rolling,
            settled=where(complete, 1.0, 0.0),
            build_up=where(sample.steering_wheel_rate > 0.0, 1.0, -1.0),
            excitation=1.0,
            residual=0.0,
            damping=0.0,
            aligning_gain=1.0,
        )
        verdict_state, verdict = self.verdict.step(state.verdict, seen)
        return self.State(filter_state, verdict_state), self.Output(estimate, seen, verdict)

    def run_of(self, last: Output, memory: Memory, calibrated: bool, start_time: float = 0.0) -> FrictionRun:
        """What is known after a last output and the memory that came with it, of a scan or a stream."""
        state = rebuild(self.init(), memory.values.tolist()).verdict
        parameters = self.filter.filter.parameters
        return FrictionRun(
            self.name, self.verdict, state, last.seen, last.verdict, calibrated, start_time, parameters=parameters
        )
