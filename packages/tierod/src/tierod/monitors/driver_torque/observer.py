"""Observers of a steering column: torques of hands and disturbance, at once or some milliseconds later."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, Tree, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import all_of, both, either, maximum, present, select, sqrt, where
from tierod.methods.estimators.observers import FixedLag
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.column_observation import MotorTorque
from tierod.models.steering_column import ColumnOutput
from tierod.monitors.driver_torque.design import (
    Column,
    ColumnTuning,
    Layout,
    column_of_vehicle,
    design,
    process_noises,
    usual_tuning,
)
from tierod.vehicles import Vehicle

UNKNOWN = 10.0  # standard deviation of an unknown torque [N m]; more than hands usually give


class ColumnSample(NamedTuple):
    """Measurements of a column at one instant; NaN where a value is missing."""

    motor_torque: Annotated[Scalar, "N*m"]  # torque at the motor's shaft
    steering_wheel_angle: Annotated[Scalar, "rad"]  # angle above the torsion bar
    motor_angle_mechanical: Annotated[Scalar, "rad"]  # angle of the motor's shaft
    driver_torque: Annotated[Scalar, "N*m"]  # torque in the torsion bar, positive towards left


class StartState(NamedTuple):
    """State of the gap handling."""

    motor_torque: Annotated[Scalar, "N*m"]  # last valid motor torque
    missing: Annotated[Scalar, "s"]  # time for which samples have been incomplete [s]
    started: Annotated[Scalar, ""]  # 1 after the first complete sample
    settling: Annotated[Scalar, "s"]  # remaining settling time after a start [s]

    @property
    def unknown(self) -> Scalar:
        """Variance that an observer adds to its torques until it has settled [N**2*m**2]."""
        return where(both(self.started > 0.5, self.settling <= 0.0), 0.0, UNKNOWN**2)


class Phase(NamedTuple):
    """Mode of an observer in a sample."""

    # torque of the previous sample, which acts until this one; held where it is missing
    motor_torque: Annotated[Scalar, "N*m"]
    measured: tuple[Scalar, ...]  # outputs that the observer uses, in the order of the layout
    restart: Annotated[Scalar, ""]  # 1 where the observer restarts from this sample, as if at rest
    following: Annotated[Scalar, ""]  # 1 where it continues or restarts; 0 where it is held
    ready: Annotated[Scalar, ""]  # 1 where the estimate can be used

    def chosen(self, resting: Tree, moved: Tree, held: Tree) -> Tree:
        """The tree that belongs to the phase: restarted, updated or held."""
        return select(self.following, select(self.restart, resting, moved), held)


@dataclass(frozen=True)
class Starting:
    """Starts at the first complete sample, restarts after a gap above `longest_gap`; shorter ones are bridged."""

    layout: Layout  # layout of the observer
    # longest bridged gap; 0.05 s is a quarter of the period at which a driver still turns the wheel (5 Hz)
    longest_gap: Annotated[float, "s"] = 0.05
    # settling time after a start with a turning wheel; ten time constants of the filter for jumps
    settling_time: Annotated[float, "s"] = 0.1

    Sample = ColumnSample

    def init(self) -> StartState:
        return StartState(0.0, 0.0, 0.0, 0.0)

    def step(self, state: StartState, sample: ColumnSample) -> tuple[StartState, Phase]:
        measured = tuple(getattr(sample, name) for name in self.layout.outputs)
        motor = where(present(sample.motor_torque), sample.motor_torque, state.motor_torque)
        complete = all_of(present(sample.motor_torque), *(present(value) for value in measured))
        missing = where(complete, 0.0, state.missing + self.layout.sample_time)
        restart = where(complete, either(state.started < 0.5, state.missing > self.longest_gap), 0.0)
        started = where(complete, 1.0, state.started)
        following = all_of(started > 0.5, missing <= self.longest_gap)
        left = maximum(state.settling - self.layout.sample_time, 0.0)
        settling = where(restart, self.settling_time, where(following, left, state.settling))
        ready = where(all_of(following, settling <= 0.0), 1.0, 0.0)
        return StartState(motor, missing, started, settling), Phase(
            state.motor_torque, measured, restart, following, ready
        )


class ColumnEstimate(NamedTuple):
    """Estimate of an observer of the column; deviations are standard deviations for the assumed column."""

    hand_torque: Annotated[Scalar, "N*m"]  # torque of the driver's hands on the steering wheel
    hand_torque_deviation: Annotated[Scalar, "N*m"]  # its standard deviation
    # torque that the motor overcomes at its shaft besides the column: dry friction, rack and road
    disturbance_torque: Annotated[Scalar, "N*m"]
    disturbance_torque_deviation: Annotated[Scalar, "N*m"]  # its standard deviation
    # steering_wheel_angle, motor_angle_mechanical, gear_angle: filtered; the gear's is that of the shaft below the bar
    steering_wheel_angle: Annotated[Scalar, "rad"]
    motor_angle_mechanical: Annotated[Scalar, "rad"]
    gear_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]  # steering_wheel_rate, motor_speed, gear_rate: likewise
    motor_speed: Annotated[Scalar, "rad/s"]
    gear_rate: Annotated[Scalar, "rad/s"]
    offset: Annotated[Scalar, ""]  # offset of the sensor that the tuning names, in its unit; 0 where it names none
    innovation: ColumnOutput  # measured less predicted; NaN where missing, 0 for a sensor that the tuning leaves out
    nis: Annotated[Scalar, ""]  # normalised innovation squared over the present outputs
    present: Annotated[Scalar, ""]  # number of present outputs
    # 1 while the estimate can be used; 0 before the first complete sample, in a long gap, and while settling
    ready: Annotated[Scalar, ""]


class ColumnMemory(NamedTuple):
    """State of the observer's filters, and of the gaps in its samples."""

    bank: Tree
    start: StartState


@dataclass(frozen=True)
class ColumnObserver:
    """Torques of hands and disturbance, and the states of a steering column, from angles and torques.

    Three Kalman filters with stationary gains run in parallel: for hands whose torque has a rate, for hands that jump,
    and for friction that reverses. The observer starts at its first complete sample as if at rest, and restarts after a
    long gap; in a gap the standard deviations grow, and while it settles they are those of an unknown torque. A missing
    motor torque is held.

    Without the motor's angle (`outputs` of the tuning) the column below the bar is observed through the bar alone: the
    disturbance torque becomes slower and noisier, and an offset of the bar cannot be separated from its twist.

    Source: Raffone, eq (18), with no noise on the mechanical states, a rate of the hands' torque, and a bank.
    """

    bank: StationaryBank
    starting: Starting

    Sample = ColumnSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a vehicle's column, see `column_of_vehicle`.

        Args:
            tuning: tuning; that of a bench or of the road where None, see `usual_tuning`
        """
        return cls.of_parameters(column_of_vehicle(vehicle, sample_time), sample_time, tuning or usual_tuning(vehicle))

    @classmethod
    def of_parameters(
        cls, parameters: Column, sample_time: float = 1e-3, tuning: ColumnTuning | None = None
    ) -> ColumnObserver:
        """The observer of a column.

        Args:
            tuning: tuning; that of a bench where None
        """
        made = design(parameters, sample_time, tuning or ColumnTuning())
        return cls(made.bank, Starting(made.layout))

    def init(self) -> ColumnMemory:
        return ColumnMemory(self.bank.init(), self.starting.init())

    def step(self, state: ColumnMemory, sample: ColumnSample) -> tuple[ColumnMemory, ColumnEstimate]:
        start, phase = self.starting.step(state.start, sample)
        given = self.bank.Sample(MotorTorque(phase.motor_torque), self.bank.model.Output(*phase.measured))
        moved, estimate = self.bank.step(state.bank, given)
        resting = resting_state(self.bank.model, self.starting.layout, sample)
        bank = phase.chosen(self.bank.at(resting), moved, state.bank)
        return ColumnMemory(bank, start), self._estimate(start, self.bank.mean(bank), estimate, phase)

    def _estimate(self, start: StartState, mean: Tree, estimate: Tree, phase: Phase) -> ColumnEstimate:
        layout, unknown = self.starting.layout, start.unknown
        hand = estimate.variance.hand_torque + layout.hand_torque_growth * start.missing + unknown
        disturbance = estimate.variance.disturbance_torque + layout.disturbance_torque_growth * start.missing
        innovation = dict(zip(layout.outputs, values_of(estimate.innovation), strict=True))
        return ColumnEstimate(
            mean.hand_torque,
            sqrt(hand),
            mean.disturbance_torque,
            sqrt(disturbance + unknown),
            mean.steering_wheel_angle,
            mean.motor_angle,
            getattr(mean, "gear_angle", mean.motor_angle / layout.motor_ratio),
            mean.steering_wheel_rate,
            mean.motor_speed,
            getattr(mean, "gear_rate", mean.motor_speed / layout.motor_ratio),
            getattr(mean, layout.offset) if layout.offset else 0.0,
            ColumnOutput(*(innovation.get(name, 0.0) for name in ColumnOutput._fields)),
            where(phase.following, estimate.nis, 0.0),
            where(phase.following, estimate.present, 0.0),
            phase.ready,
        )


def resting_state(model: Any, layout: Layout, sample: ColumnSample) -> Tree:
    """State of a column filter for a column at rest under this sample; zeros where values are missing."""
    ratio, bar, wheel = layout.motor_ratio, _there(sample.driver_torque), _there(sample.steering_wheel_angle)
    gear = wheel - bar / layout.stiffness
    known_motor = "motor_angle_mechanical" in layout.outputs
    motor = _there(sample.motor_angle_mechanical) if known_motor else ratio * gear
    known = {
        "steering_wheel_angle": wheel,
        "gear_angle": gear,
        "motor_angle": motor,
        "hand_torque": bar,
        "disturbance_torque": _there(sample.motor_torque) + bar / ratio,
    }
    if layout.offset == "motor_angle_offset":
        known |= {"motor_angle": ratio * gear, "motor_angle_offset": motor - ratio * gear}
    return model.State(*(known.get(name, 0.0) for name in model.State._fields))


def _there(value: Scalar) -> Scalar:
    return where(present(value), value, 0.0)


DELAY = 0.02  # default lag [s]; long enough to see an edge from both sides
# Random walk of the torque's rate [N m/s^1.5], tuned on simulated benches with hands that jump and hands that pull
# within 100 ms; samples after an edge are known here, so it may be larger than without a lag.
RATE_WALK = 40.0
# Random walk of the disturbance torque [N m/s^0.5], from the same runs; one filter for steady and reversing friction.
DISTURBANCE_WALK = 0.3


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
    """

    smoother: FixedLag  # fixed-lag smoother with stationary gain
    starting: Starting  # behaviour in gaps

    Sample = ColumnSample

    @classmethod
    def of_vehicle(
        cls, vehicle: Vehicle, sample_time: float = 1e-3, delay: float = DELAY, tuning: ColumnTuning | None = None
    ) -> DelayedHandTorque:
        """The smoother of a vehicle's column, see `ColumnObserver.of_vehicle`.

        Args:
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
            tuning: tuning, that of a bench where None; its walks count where they are larger than those of
                this module
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
        return DelayedState(self.smoother.init(), self.starting.init())

    def step(self, state: DelayedState, sample: ColumnSample) -> tuple[DelayedState, DelayedEstimate]:
        start, phase = self.starting.step(state.start, sample)
        given = self.smoother.Sample(MotorTorque(phase.motor_torque), self.smoother.model.Output(*phase.measured))
        moved, estimate = self.smoother.step(state.smoother, given)
        resting = self.smoother.at(resting_state(self.smoother.model, self.starting.layout, sample))
        smoother = phase.chosen(resting, moved, state.smoother)
        growth = self.starting.layout.hand_torque_growth * start.missing
        variance = self.smoother.variances[0] + growth + start.unknown
        oldest = phase.chosen(resting.recent[0][-1], estimate.smoothed.hand_torque, state.smoother.recent[0][-1])
        return DelayedState(smoother, start), DelayedEstimate(oldest, sqrt(variance), phase.ready)
