"""Torque of the driver's hands some milliseconds ago: a fixed-lag smoother, for uses that can wait."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar, Tree
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import sqrt
from tierod.methods.estimators.fixed_lag import FixedLag
from tierod.models.column_observation import MotorTorque
from tierod.monitors.driver_torque.design import Column, column_of_vehicle, design, process_noises
from tierod.monitors.driver_torque.observer import resting_state
from tierod.monitors.driver_torque.starting import ColumnSample, Starting, StartState
from tierod.monitors.driver_torque.tuning import ColumnTuning, usual_tuning
from tierod.vehicles import Vehicle

DELAY = 0.02
"""Default lag [s]; long enough to see an edge from both sides."""

RATE_WALK = 40.0
"""Random walk of the torque's rate [N m/s^1.5], tuned on simulated benches with hands that jump and hands that pull
within 100 ms; samples after an edge are known here, so it may be larger than without a lag."""


DISTURBANCE_WALK = 0.3
"""Random walk of the disturbance torque [N m/s^0.5], from the same runs; one filter for steady and reversing
friction."""


def smoothing(tuning: ColumnTuning) -> ColumnTuning:
    """A tuning without jumps and reversals: one filter, with the walks of this module as lower bounds."""
    return replace(
        tuning,
        hand_torque_walk=0.0,
        reversal_walk=0.0,
        hand_torque_rate_walk=max(tuning.hand_torque_rate_walk, RATE_WALK),
        disturbance_torque_walk=max(tuning.disturbance_torque_walk, DISTURBANCE_WALK),
    )


class DelayedEstimate(NamedTuple):
    """Delayed torque of the hands, its standard deviation, and whether it can be used."""

    hand_torque: Annotated[Scalar, "N*m"]
    hand_torque_deviation: Annotated[Scalar, "N*m"]
    ready: Annotated[Scalar, ""]


class DelayedState(NamedTuple):
    """State of the smoother, and of the gaps in its samples."""

    smoother: Tree
    start: StartState


@dataclass(frozen=True)
class DelayedHandTorque:
    """Torque of the hands `smoother.lag` samples ago, from all samples up to now.

    One filter suffices: a lag of 20 ms shows an edge from both sides, and smooths jumping and pulling hands equally
    well. Gaps are treated as in `ColumnObserver`; the deviation grows with the gap.

    Args:
        smoother: fixed-lag smoother with stationary gain
        starting: behaviour in gaps
    """

    smoother: FixedLag
    starting: Starting

    Sample = ColumnSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 1e-3, delay: float = DELAY, tuning: ColumnTuning | None = None
    ) -> DelayedHandTorque:
        """The smoother of a vehicle's column, see `ColumnObserver.of_vehicle`.

        Args:
            vehicle: vehicle with gear stiffness, or with the inertia of its whole column
            sample_time: sampling interval [s]
            delay: lag, at least a sample [s]
            tuning: tuning; where None that of a bench or of the road, see `usual_tuning`
        """
        return cls.of_parameters(
            column_of_vehicle(vehicle, sample_time), sample_time, delay, tuning or usual_tuning(vehicle)
        )

    @classmethod
    def of_parameters(
        cls, parameters: Column, sample_time: float = 1e-3, delay: float = DELAY, tuning: ColumnTuning | None = None
    ) -> DelayedHandTorque:
        """The smoother of a column.

        Args:
            parameters: `ColumnParameters` or `TwoInertiaParameters`
            sample_time: sampling interval [s]
            delay: lag [s]
            tuning: tuning, that of a bench where None; its walks count where they are larger than those of this module

        Raises:
            ParameterError: as in `require_fit`, or a delay shorter than a sample
        """
        if not delay >= sample_time:
            raise ParameterError(f"delay is {delay} s; expected at least a sample of {sample_time} s")
        smooth = smoothing(tuning or ColumnTuning())
        made = design(parameters, sample_time, smooth)
        (noise,) = process_noises(made.observation.discrete.states, parameters, sample_time, smooth)
        smoother = FixedLag.design(
            made.observation.discrete,
            made.observation.model,
            made.observation.parameters,
            noise,
            smooth.variances(),
            ("hand_torque",),
            round(delay / sample_time),
        )
        return cls(smoother, Starting(made.layout))

    def init(self) -> DelayedState:
        """State before the first sample: not started."""
        return DelayedState(self.smoother.init(), self.starting.init())

    def step(self, state: DelayedState, sample: ColumnSample) -> tuple[DelayedState, DelayedEstimate]:
        """Process one sample."""
        start, phase = self.starting.step(state.start, sample)
        given = self.smoother.Sample(MotorTorque(phase.motor_torque), self.smoother.model.Output(*phase.measured))
        moved, estimate = self.smoother.step(state.smoother, given)
        resting = self.smoother.at(resting_state(self.smoother.model, self.starting.layout, sample))
        smoother = phase.chosen(resting, moved, state.smoother)
        growth = self.starting.layout.hand_torque_growth * start.missing
        variance = self.smoother.variances[0] + growth + start.unknown
        oldest = phase.chosen(resting.recent[0][-1], estimate.smoothed.hand_torque, state.smoother.recent[0][-1])
        return DelayedState(smoother, start), DelayedEstimate(oldest, sqrt(variance), phase.ready)
