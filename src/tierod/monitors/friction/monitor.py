"""The default friction monitor: the pre-sliding estimator with its running verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from tierod.block import rebuild
from tierod.errors import InputError
from tierod.findings import Finding
from tierod.graph import Memory, Result
from tierod.monitors.friction.conditioning import SAMPLE_TIME
from tierod.monitors.friction.judgement import judge
from tierod.monitors.friction.presliding import PreslidingFrictionFilter
from tierod.monitors.friction.presliding_tuning import FrictionTorque
from tierod.monitors.friction.run import FrictionRun
from tierod.monitors.friction.steering_sample import SteeringSample
from tierod.monitors.friction.verdict import UNKNOWN_LIMITS, FrictionLimits, FrictionVerdict, VerdictOutput
from tierod.monitors.friction.verdict_state import VerdictSample
from tierod.vehicles import Vehicle

NAME = "friction, pre-sliding estimator"


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
        limits = vehicle.parameters_for(FrictionLimits) if vehicle.calibrated else UNKNOWN_LIMITS
        verdict = FrictionVerdict(
            limits, sample_time=sample_time, learnt_level=learnt_level, learnt_deviation=learnt_deviation
        )
        return cls(PreslidingFrictionFilter.of_vehicle(vehicle, sample_time), verdict)

    def init(self) -> State:
        """Nothing learnt yet."""
        return self.State(self.filter.init(), self.verdict.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, Output]:
        """One sample on."""
        filter_state, estimate = self.filter.step(state.filter, sample)
        seen = VerdictSample(*(getattr(estimate, name) for name in VerdictSample._fields))
        verdict_state, verdict = self.verdict.step(state.verdict, seen)
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
        estimate = last.estimate
        seen = VerdictSample(*(getattr(estimate, name) for name in VerdictSample._fields))
        evidence = {
            "dahl_angle_deg": math.degrees(estimate.dahl_angle),
            "aligning_gain": estimate.aligning_gain,
            "trail_drop_per_Nm": estimate.trail_drop,
            "load_share": estimate.load_share,
            "torque_offset_Nm": estimate.offset,
            "damping_Nms_per_rad": estimate.damping,
            "inertia_kgm2": estimate.inertia,
        }
        state = self.state_of(memory).verdict
        return FrictionRun(
            NAME, self.verdict, state, seen, last.verdict, calibrated, start_time, evidence, self.filter.parameters
        )

    def state_of(self, memory: Memory) -> State:
        """The state of a run by name: `state_of(result.state).verdict.figures`."""
        return rebuild(self.init(), memory.values.tolist())
