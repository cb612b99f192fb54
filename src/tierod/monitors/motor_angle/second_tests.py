"""Tests for sensors that stand still, turn backwards, or too far, which a cumulative sum of the angle misses."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, any_of, both, maximum, minimum, negated, present, where
from tierod.methods.detectors.threshold import Debounce
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.monitors.motor_angle.signals import MotorAngleSample
from tierod.physics.angle import wrapped


class SensorBesideObserver(NamedTuple):
    """Estimate of the observer, and the sensor's reading.

    Args:
        estimate: of the observer
        motor_angle_mechanical: of the sensor; NaN where the sample brings none
    """

    estimate: MotorAngleObserver.Output
    motor_angle_mechanical: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class Increments:
    """Increments of sensor and observer over windows in which the motor turns: compared, they show direction and scale.

    Args:
        sample_time: [s]
        window: long beside the sensor's noise, short beside a reversal [s]
        least_speed: of the observer on average over a window, mechanical [rad/s]

    A window that begins or ends with a standing motor does not count.
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    window: Annotated[float, "s", POSITIVE] = 0.01
    least_speed: Annotated[float, "rad/s", POSITIVE] = 10.0

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """Last reading, whether there is one, gain of the sensor, the observer's start, time, standing."""

        last: Annotated[Scalar, "rad"]
        begun: Annotated[Scalar, ""]
        gained: Annotated[Scalar, "rad"]
        start: Annotated[Scalar, "rad"]
        elapsed: Annotated[Scalar, "s"]
        stood: Annotated[Scalar, ""]

    class Output(NamedTuple):
        """Gains over the window so far, and whether one ends here in which the motor turned throughout (1.0, 0.0)."""

        sensor: Annotated[Scalar, "rad"]
        observer: Annotated[Scalar, "rad"]
        complete: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    def step(self, state: State, sample: SensorBesideObserver) -> tuple[State, Output]:
        """One sample on; windows end with a reading."""
        fresh = present(sample.motor_angle_mechanical)
        step = wrapped(where(fresh, sample.motor_angle_mechanical, state.last) - state.last)
        gained = state.gained + where(both(fresh, state.begun), step, 0.0)
        elapsed = minimum(state.elapsed + self.sample_time, 10.0 * self.window)
        seen = sample.estimate
        stood = where(seen.standing, 1.0, state.stood)
        ends = both(fresh, elapsed + 0.5 * self.sample_time > self.window)
        turned = seen.motor_angle - state.start
        complete = all_of(
            ends,
            stood < 0.5,
            elapsed < 2.0 * self.window,
            absolute(turned) > self.least_speed * self.window,
        )
        after = self.State(
            where(fresh, sample.motor_angle_mechanical, state.last),
            where(fresh, 1.0, state.begun),
            where(ends, 0.0, gained),
            where(ends, seen.motor_angle, state.start),
            where(ends, 0.0, elapsed),
            where(ends, where(seen.standing, 1.0, 0.0), stood),
        )
        return after, self.Output(gained, turned, where(complete, 1.0, 0.0))


@dataclass(frozen=True)
class Stuck:
    """Alarm when the observer turns on and the sensor does not move.

    Args:
        still: a sensor that stays within this has not moved: four times its noise and step [rad]
        travel: of the observer meanwhile, mechanical: far more than its error [rad]
    """

    still: Annotated[float, "rad", POSITIVE] = 0.006
    travel: Annotated[float, "rad", POSITIVE] = 0.15

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """Angles of sensor and observer when the sensor last moved; whether there is such a place; the alarm."""

        sensor: Annotated[Scalar, "rad"]
        observer: Annotated[Scalar, "rad"]
        begun: Annotated[Scalar, ""]
        alarm: Annotated[Scalar, ""]

    class Output(NamedTuple):
        """Angle that the observer has turned meanwhile, and whether that is too far (1.0, 0.0)."""

        turned: Annotated[Scalar, "rad"]
        alarm: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: SensorBesideObserver, enabled: Scalar | bool = True) -> tuple[State, Output]:
        """One sample on, judged where it brings a reading.

        A standing motor, and a sample that is not enabled (logic), begin anew: the angle is unknown then.
        """
        fresh = present(sample.motor_angle_mechanical)
        away = where(fresh, sample.motor_angle_mechanical, state.sensor) - state.sensor
        moved = all_of(fresh, absolute(wrapped(away)) > self.still)
        anew = any_of(both(fresh, state.begun < 0.5), moved, sample.estimate.standing > 0.5, negated(enabled))
        sensor = where(both(anew, fresh), sample.motor_angle_mechanical, state.sensor)
        observer = where(anew, sample.estimate.motor_angle, state.observer)
        turned = where(state.begun, sample.estimate.motor_angle - observer, 0.0)
        alarm = where(anew, 0.0, where(both(fresh, absolute(turned) > self.travel), 1.0, state.alarm))
        return self.State(sensor, observer, where(fresh, 1.0, state.begun), alarm), self.Output(turned, alarm)


@dataclass(frozen=True)
class NotFollowing:
    """Alarm when the sensor stays away from its target: the drive has stalled, so that its currents determine no angle.

    A sensor that is stuck, or whose sine and cosine are swapped, makes the current control hold the rotor; so does a
    blocked motor. This test cannot separate them.

    Args:
        widest: following error of a fault-free drive, with a margin [rad]
        hold: for so long [s]
        confirmed_hold: for so long where currents and voltages confirm the sensor: a load beyond the motor's torque, or
            a target beyond its speed, is no fault while it passes [s]
        sample_time: [s]
        least_course: a target that has never changed by so much is not the one that is controlled [rad]
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    widest: Annotated[float, "rad", POSITIVE] = 1.0
    hold: Annotated[float, "s", POSITIVE] = 0.02
    confirmed_hold: Annotated[float, "s", POSITIVE] = 0.5
    least_course: Annotated[float, "rad", POSITIVE] = 0.5
    holding: Debounce = field(init=False, repr=False)
    holding_on: Debounce = field(init=False, repr=False)

    Sample = MotorAngleSample

    class State(NamedTuple):
        """Target, sensor, whether each was received, the first target, whether it has moved since, and the holds."""

        target: Annotated[Scalar, "rad"]
        sensor: Annotated[Scalar, "rad"]
        seen_target: Annotated[Scalar, ""]
        seen_sensor: Annotated[Scalar, ""]
        first: Annotated[Scalar, "rad"]
        moved: Annotated[Scalar, ""]
        held: Debounce.State
        held_on: Debounce.State

    class Output(NamedTuple):
        """Following error, 0 without a target, and whether it has been too large for too long (1.0, 0.0)."""

        error: Annotated[Scalar, "rad"]
        alarm: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        object.__setattr__(self, "holding_on", Debounce(self.confirmed_hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, self.holding.init(), self.holding_on.init())

    def step(self, state: State, sample: MotorAngleSample, confirmed: Scalar | bool = False) -> tuple[State, Output]:
        """One sample on; `confirmed` (logic) where currents and voltages give the angle that the sensor reads."""
        wanted, fresh = present(sample.target_motor_angle_mechanical), present(sample.motor_angle_mechanical)
        target = where(wanted, sample.target_motor_angle_mechanical, state.target)
        sensor = where(fresh, sample.motor_angle_mechanical, state.sensor)
        seen = where(wanted, 1.0, state.seen_target), where(fresh, 1.0, state.seen_sensor)
        first = where(both(wanted, state.seen_target < 0.5), target, state.first)
        moved = where(both(seen[0], absolute(target - first) > self.least_course), 1.0, state.moved)
        error = where(all_of(*seen, moved), target - sensor, 0.0)
        away = absolute(error) > self.widest
        held, out = self.holding.step(state.held, where(both(away, negated(confirmed)), 1.0, 0.0))
        held_on, out_on = self.holding_on.step(state.held_on, where(away, 1.0, 0.0))
        alarm = maximum(out.active, out_on.active)
        return self.State(target, sensor, *seen, first, moved, held, held_on), self.Output(error, alarm)
