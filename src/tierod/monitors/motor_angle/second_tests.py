"""Tests for sensors that stand still, turn backwards or too far, which a CUSUM of the angle misses."""

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
        estimate: output of the observer
        motor_angle_mechanical: reading of the sensor; NaN where the sample has none
    """

    estimate: MotorAngleObserver.Output
    motor_angle_mechanical: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class Increments:
    """Increments of sensor and observer over windows with a turning motor, for a comparison of direction and scale.

    Args:
        sample_time: sampling interval [s]
        window: window, long against the sensor's noise, short against a reversal [s]
        least_speed: least mean speed of the observer over a window, mechanical [rad/s]

    A window that begins or ends with a standing motor does not count.
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    window: Annotated[float, "s", POSITIVE] = 0.01
    least_speed: Annotated[float, "rad/s", POSITIVE] = 10.0

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """Last reading, whether there is one, increment of the sensor, the observer's start, time, standing."""

        last: Annotated[Scalar, "rad"]
        begun: Annotated[Scalar, ""]
        gained: Annotated[Scalar, "rad"]
        start: Annotated[Scalar, "rad"]
        elapsed: Annotated[Scalar, "s"]
        stood: Annotated[Scalar, ""]

    class Output(NamedTuple):
        """Increments over the window so far, and whether one with a turning motor ends here (1.0, 0.0)."""

        sensor: Annotated[Scalar, "rad"]
        observer: Annotated[Scalar, "rad"]
        complete: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    def step(self, state: State, sample: SensorBesideObserver) -> tuple[State, Output]:
        """Process one sample; windows end with a reading."""
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
    """Alarm for a sensor that does not move while the observer turns.

    Args:
        still: range within which a sensor has not moved [rad]; four times its noise and step
        travel: turn of the observer meanwhile, mechanical [rad]; far more than its error
    """

    still: Annotated[float, "rad", POSITIVE] = 0.006
    travel: Annotated[float, "rad", POSITIVE] = 0.15

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """Angles of sensor and observer when the sensor last moved, whether they are valid, and the alarm."""

        sensor: Annotated[Scalar, "rad"]
        observer: Annotated[Scalar, "rad"]
        begun: Annotated[Scalar, ""]
        alarm: Annotated[Scalar, ""]

    class Output(NamedTuple):
        """Turn of the observer since the sensor last moved, and whether it is too far (1.0, 0.0)."""

        turned: Annotated[Scalar, "rad"]
        alarm: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: SensorBesideObserver, enabled: Scalar | bool = True) -> tuple[State, Output]:
        """Process one sample; the alarm can rise at a reading only.

        A standing motor, or a sample that is not enabled (logic), restarts the test: the angle is then unknown.
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
    """Alarm for a sensor that stays away from its target: the drive has stalled, and its currents give no angle.

    A sensor that is stuck, or whose sine and cosine are swapped, makes the current control hold the rotor; so does a
    blocked motor. This test cannot separate them.

    Args:
        widest: largest following error of a fault-free drive, with a margin [rad]
        hold: time for which the error must be larger [s]
        confirmed_hold: the same time where currents and voltages confirm the sensor [s]; a load beyond the motor's
            torque, or a target beyond its speed, is not a fault while it passes
        sample_time: sampling interval [s]
        least_course: least change of a target for the test [rad]; a smaller one is not the target of the control
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
        """Target, sensor, whether each was received, first target, whether it has moved since, and the holds."""

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
        """Process one sample; `confirmed` (logic) where currents and voltages agree with the sensor."""
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
