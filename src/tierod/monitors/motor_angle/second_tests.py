"""What a cumulative sum of the angle's difference misses: sensors that stand still, turn backwards, or too far."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, minimum, present, sign, where
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.threshold import Debounce
from tierod.physics.angle import wrapped


class Turning(NamedTuple):
    """One sample of the sensor beside the observer.

    Args:
        motor_angle_mechanical: of the sensor; NaN where the sample brings none
        motor_angle, motor_speed: of the observer
        standing: 1 while the currents tell no angle
    """

    motor_angle_mechanical: Annotated[float, "rad"]
    motor_angle: Annotated[float, "rad"]
    motor_speed: Annotated[float, "rad/s"]
    standing: Annotated[float, ""]


@dataclass(frozen=True)
class Increments:
    """What sensor and observer gain over windows in which the motor turns: compared, they tell direction and scale.

    Args:
        sample_time: [s]
        window: long beside the sensor's noise, short beside a reversal [s]
        least_speed: of the observer on average over a window, mechanical [rad/s]

    A window that begins or ends with a standing motor tells nothing.
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    window: Annotated[float, "s", POSITIVE] = 0.01
    least_speed: Annotated[float, "rad/s", POSITIVE] = 10.0

    Sample = Turning

    class State(NamedTuple):
        """Last reading, whether there is one, what was gained by the sensor, the observer's start, time, standing."""

        last: Any
        begun: Any
        gained: Any
        start: Any
        elapsed: Any
        stood: Any

    class Output(NamedTuple):
        """Gains over the window that ends with this sample, and whether one ends that tells (1.0, 0.0)."""

        sensor: Annotated[float, "rad"]
        observer: Annotated[float, "rad"]
        tells: Annotated[float, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on; windows end with a reading."""
        fresh = present(sample.motor_angle_mechanical)
        step = wrapped(where(fresh, sample.motor_angle_mechanical, state.last) - state.last)
        gained = state.gained + where(both(fresh, state.begun), step, 0.0)
        elapsed = minimum(state.elapsed + self.sample_time, 10.0 * self.window)
        stood = where(sample.standing, 1.0, state.stood)
        ends = both(fresh, elapsed + 0.5 * self.sample_time > self.window)
        turned = sample.motor_angle - state.start
        tells = all_of(
            ends,
            stood < 0.5,
            elapsed < 2.0 * self.window,
            absolute(turned) > self.least_speed * self.window,
        )
        after = self.State(
            where(fresh, sample.motor_angle_mechanical, state.last),
            where(fresh, 1.0, state.begun),
            where(ends, 0.0, gained),
            where(ends, sample.motor_angle, state.start),
            where(ends, 0.0, elapsed),
            where(ends, where(sample.standing, 1.0, 0.0), stood),
        )
        return after, self.Output(gained, turned, where(tells, 1.0, 0.0))


@dataclass(frozen=True)
class Backwards:
    """Alarm when the sensor turns against the observer: sine and cosine, or two phases, are swapped.

    Args:
        windows: so many more against than with []
    """

    windows: Annotated[float, "", POSITIVE] = 3.0
    sum: Cusum = field(init=False, repr=False)

    Sample = Increments.Output
    Output = Cusum.Output

    def __post_init__(self) -> None:
        object.__setattr__(self, "sum", Cusum(0.0, self.windows, self.windows, sides="upper"))
        check_ranges(self)

    def init(self) -> Cusum.State:
        """Nothing seen."""
        return self.sum.init()

    def step(self, state: Cusum.State, sample: Any) -> tuple[Cusum.State, Cusum.Output]:
        """One sample on."""
        return self.sum.step(state, -sign(sample.sensor * sample.observer), enabled=sample.tells)


@dataclass(frozen=True)
class Stuck:
    """Alarm when the observer turns on and the sensor does not move.

    Args:
        still: a sensor that stays within this has not moved: four times its noise and step [rad]
        travel: of the observer meanwhile, mechanical: far more than its error [rad]
    """

    still: Annotated[float, "rad", POSITIVE] = 0.006
    travel: Annotated[float, "rad", POSITIVE] = 0.15

    Sample = Turning

    class State(NamedTuple):
        """Where the sensor was when it last moved, and the observer then; whether there is such a place; the alarm."""

        sensor: Any
        observer: Any
        begun: Any
        alarm: Any

    class Output(NamedTuple):
        """What the observer has turned meanwhile, and whether that is too far (1.0, 0.0)."""

        turned: Annotated[float, "rad"]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        check_ranges(self)

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0, 0.0, 0.0)

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on, judged where it brings a reading; a standing motor begins anew: its observer knows nothing."""
        fresh = present(sample.motor_angle_mechanical)
        away = where(fresh, sample.motor_angle_mechanical, state.sensor) - state.sensor
        moved = all_of(fresh, absolute(wrapped(away)) > self.still)
        anew = where(both(fresh, state.begun < 0.5), 1.0, where(moved, 1.0, where(sample.standing, 1.0, 0.0)))
        sensor = where(both(anew, fresh), sample.motor_angle_mechanical, state.sensor)
        observer = where(anew, sample.motor_angle, state.observer)
        turned = where(state.begun, sample.motor_angle - observer, 0.0)
        alarm = where(anew, 0.0, where(both(fresh, absolute(turned) > self.travel), 1.0, state.alarm))
        return self.State(sensor, observer, where(fresh, 1.0, state.begun), alarm), self.Output(turned, alarm)


class Following(NamedTuple):
    """One sample of the angle's control.

    Args:
        target_motor_angle_mechanical, motor_angle_mechanical: wanted and measured; NaN where the sample brings none
    """

    target_motor_angle_mechanical: Annotated[float, "rad"]
    motor_angle_mechanical: Annotated[float, "rad"]


@dataclass(frozen=True)
class NotFollowing:
    """Alarm when the sensor stays away from its target: the drive has stalled, so that its currents tell no angle.

    A sensor that is stuck, or whose sine and cosine are swapped, makes the current control hold the rotor; so does a
    blocked motor. Which of them it is, this test cannot tell.

    Args:
        widest: following error of a sound drive, with a margin [rad]
        hold: for so long [s]
        sample_time: [s]
        least_course: a target that has never changed by so much is told to nobody, as under control of torque [rad]
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    widest: Annotated[float, "rad", POSITIVE] = 1.0
    hold: Annotated[float, "s", POSITIVE] = 0.02
    least_course: Annotated[float, "rad", POSITIVE] = 0.5
    holding: Debounce = field(init=False, repr=False)

    Sample = Following

    class State(NamedTuple):
        """Target, sensor, whether each was seen, the first target, whether it has moved since, and the hold."""

        target: Any
        sensor: Any
        seen_target: Any
        seen_sensor: Any
        first: Any
        moved: Any
        held: Any

    class Output(NamedTuple):
        """Following error, 0 without a target, and whether it has been too large for too long (1.0, 0.0)."""

        error: Annotated[float, "rad"]
        alarm: Annotated[float, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """Nothing seen."""
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, self.holding.init())

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on."""
        told, fresh = present(sample.target_motor_angle_mechanical), present(sample.motor_angle_mechanical)
        target = where(told, sample.target_motor_angle_mechanical, state.target)
        sensor = where(fresh, sample.motor_angle_mechanical, state.sensor)
        seen = where(told, 1.0, state.seen_target), where(fresh, 1.0, state.seen_sensor)
        first = where(both(told, state.seen_target < 0.5), target, state.first)
        moved = where(both(seen[0], absolute(target - first) > self.least_course), 1.0, state.moved)
        error = where(all_of(*seen, moved), target - sensor, 0.0)
        held, out = self.holding.step(state.held, where(absolute(error) > self.widest, 1.0, 0.0))
        return self.State(target, sensor, *seen, first, moved, held), self.Output(error, out.active)
