"""The default friction monitor: the pre-sliding estimator with its running verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from tierod.core.block import rebuild
from tierod.core.errors import InputError
from tierod.core.findings import Finding
from tierod.core.graph import Memory, Result
from tierod.monitors.friction.conditioning import SAMPLE_TIME
from tierod.monitors.friction.judgement import judge
from tierod.monitors.friction.presliding import PreslidingFrictionFilter
from tierod.monitors.friction.presliding_tuning import FrictionTorque
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.steering_sample import SteeringSample
from tierod.monitors.friction.verdict import FrictionVerdict, VerdictOutput
from tierod.monitors.friction.verdict_state import VerdictSample
from tierod.vehicles import Vehicle

NAME = "friction, pre-sliding"
"""As in findings and in stored levels."""

LEARNT = {
    "dahl_angle_rad": "dahl_angle",
    "aligning_gain": "aligning_gain",
    "torque_offset_Nm": "offset",
    "damping_Nms_per_rad": "damping",
    "inertia_kgm2": "inertia",
}
"""Evidence of a finding that the estimator has learnt: name with unit -> field of the estimate."""


@dataclass(frozen=True)
class FrictionMonitor:
    """Estimate the friction of the steering and judge it.

    Args:
        filter: the estimator
        verdict: the judge
    """

    filter: PreslidingFrictionFilter
    verdict: FrictionVerdict

    Sample = SteeringSample

    class State(NamedTuple):
        """Of estimator and judge."""

        filter: Any
        verdict: Any

    class Output(NamedTuple):
        """Of estimator and judge."""

        estimate: FrictionTorque
        verdict: VerdictOutput

    @classmethod
    def of_vehicle(
        cls,
        vehicle: Vehicle,
        sample_time: float = SAMPLE_TIME,
        learnt_level: float | None = None,
        learnt_deviation: float = 0.0,
    ) -> FrictionMonitor:
        """The monitor for a car.

        Args:
            vehicle: its parameters and limits; without calibrated torques no absolute limit is used
            sample_time: time between two samples [s]
            learnt_level: the car's own friction from earlier drives [N*m]; None learns it in this recording
            learnt_deviation: its standard deviation [N*m]

        Raises:
            ParameterError: the vehicle file lacks a parameter; the message names it
        """
        verdict = FrictionVerdict.of_vehicle(vehicle, sample_time, learnt_level, learnt_deviation)
        return cls(PreslidingFrictionFilter.of_vehicle(vehicle, sample_time), verdict)

    def init(self) -> State:
        """Nothing learnt yet."""
        return self.State(self.filter.init(), self.verdict.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, Output]:
        """One sample on."""
        filter_state, estimate = self.filter.step(state.filter, sample)
        verdict_state, verdict = self.verdict.step(state.verdict, _seen(estimate))
        return self.State(filter_state, verdict_state), self.Output(estimate, verdict)

    def finding(self, result: Result, calibrated: bool = True, start_time: float = 0.0) -> Finding:
        """The finding of a run.

        Args:
            result: of `scan` over the whole recording, or its last part
            calibrated: whether the torques are in N*m (`Vehicle.calibrated`)
            start_time: time of the first sample that the monitor saw, in the recording [s]

        Raises:
            InputError: no samples
        """
        if not len(result):
            raise InputError("the friction monitor saw no samples; check that the signals overlap in time")
        return judge(self.run_of(result.at(len(result) - 1), result.state, calibrated, start_time))

    def run_of(self, last: Output, memory: Memory, calibrated: bool, start_time: float = 0.0) -> FrictionRun:
        """What is known after a last output and the memory that came with it, of a scan or a stream."""
        evidence = {name: getattr(last.estimate, field) for name, field in LEARNT.items()}
        state = self.state_of(memory).verdict
        return FrictionRun(
            NAME,
            self.verdict,
            state,
            _seen(last.estimate),
            last.verdict,
            calibrated,
            start_time,
            evidence,
            self.filter.parameters,
        )

    def state_of(self, memory: Memory) -> State:
        """The state of a run by name: `state_of(result.state).verdict.figures`."""
        return rebuild(self.init(), memory.values.tolist())


def _seen(estimate: FrictionTorque) -> VerdictSample:
    """What the verdict reads of an estimate."""
    return VerdictSample(*(getattr(estimate, name) for name in VerdictSample._fields))
