"""Comparison of the motor's angle sensor with the observer: when it counts, CUSUMs, tests of standstill and sense."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, any_of, both, log, maximum, minimum, negated, present, sign, where
from tierod.methods.detectors.control_charts import Cusum
from tierod.methods.detectors.threshold import Debounce
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.angle import wrapped

ANGLE_DRIFT, ANGLE_THRESHOLD = 0.044, 0.9
"""CUSUM of the electrical angle residual, one value per millisecond [rad]: see docs/explanation/motor-angle.md,
Design of the CUSUM."""

SPEED_DRIFT, SPEED_THRESHOLD = 0.5, 2.0
"""CUSUM of the speed residual, one value per 10 ms [rad/s]: see the same section."""

BACKWARDS = 3.0
"""Excess of windows against the observer over those with it that shows swapped sine and cosine, or phases [-]."""


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
class ResidualGate:
    """Gate for the residual: open where the currents determine the angle well, one value per millisecond.

    Args:
        pole_pairs: pole pairs of the motor [-]
        nominal_flux: flux of its magnets, from the vehicle file [V s]
        sample_time: sampling interval [s]
        least_speed: least electrical speed [rad/s]; below it an uncertain resistance hides the back-EMF
        most_deviation: largest standard deviation of the observer's mechanical angle [rad]
        hold: time for which all conditions must hold [s]
        start: time in which the observer learns resistance and flux [s]
        widest_flux: largest logarithm of the flux over the nominal one [-]; magnets from -40 to 120 degrees stay within
            10 % of their flux: beyond, the observer has not settled, and magnets so weak are a fault of their own
        spacing: spacing of the values that count [s]; closer residuals are not independent
    """

    pole_pairs: Annotated[float, "", POSITIVE]
    nominal_flux: Annotated[float, "V*s", POSITIVE]
    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    least_speed: Annotated[float, "rad/s", POSITIVE] = 40.0
    most_deviation: Annotated[float, "rad", POSITIVE] = 0.03
    hold: Annotated[float, "s", NOT_NEGATIVE] = 0.02
    start: Annotated[float, "s", NOT_NEGATIVE] = 5.0
    widest_flux: Annotated[float, "", POSITIVE] = 0.2
    spacing: Annotated[float, "s", POSITIVE] = 1e-3
    holding: Debounce = field(init=False, repr=False)

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """Times since the start and since a value counted, up to their limits, and the hold."""

        elapsed: Annotated[Scalar, "s"]
        since: Annotated[Scalar, "s"]
        held: Debounce.State

    class Output(NamedTuple):
        """Whether the angle of the turning motor is known, and whether this value counts (1.0, 0.0)."""

        known: Annotated[Scalar, ""]
        counts: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """State before the first sample."""
        return self.State(0.0, self.spacing, self.holding.init())

    def step(self, state: State, sample: SensorBesideObserver) -> tuple[State, Output]:
        """Process one sample."""
        half, seen = 0.5 * self.sample_time, sample.estimate
        elapsed = minimum(state.elapsed + self.sample_time, self.start + self.sample_time)
        flux = log(maximum(seen.motor_flux / self.nominal_flux, 1e-6))
        good = all_of(
            elapsed + half > self.start,
            self.pole_pairs * absolute(seen.motor_speed) > self.least_speed,
            seen.standing < 0.5,
            seen.motor_angle_standard_deviation < self.most_deviation,
            absolute(flux) < self.widest_flux,
        )
        held, debounced = self.holding.step(state.held, where(good, 1.0, 0.0))
        known = both(debounced.active, good)
        since = minimum(state.since + self.sample_time, self.spacing)
        counts = all_of(known, present(sample.motor_angle_mechanical), since + half > self.spacing)
        after = self.State(elapsed, where(counts, 0.0, since), held)
        return after, self.Output(where(known, 1.0, 0.0), where(counts, 1.0, 0.0))


@dataclass(frozen=True)
class SensorComparison:
    """Comparison of the sensor with the observer: CUSUMs of the differences of angle and speed, and two more tests.

    Args:
        gate: gate for the difference
        increments: increments of both over a window
        stuck: test for a sensor that stands still while the observer turns
        backwards: CUSUM of windows in which the sensor turns against the observer, less those with it
        angle, speed: CUSUMs of the differences of angle and of speed
    """

    gate: ResidualGate
    increments: Increments
    stuck: Stuck = field(default_factory=Stuck)
    backwards: Cusum = field(default_factory=lambda: Cusum(0.0, BACKWARDS, BACKWARDS, "upper"))
    angle: Cusum = field(default_factory=lambda: Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD))
    speed: Cusum = field(default_factory=lambda: Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD))

    Sample = SensorBesideObserver

    class State(NamedTuple):
        """State of the parts, in order."""

        gate: ResidualGate.State
        increments: Increments.State
        stuck: Stuck.State
        backwards: Cusum.State
        angle: Cusum.State
        speed: Cusum.State

    class Output(NamedTuple):
        """Whether the difference is known and counts, the sums, both increments, alarms, and statistics of two tests.

        `sensor_gain` and `observer_gain` are angles turned over a window; `early` is 1 while the observer still learns;
        `complete` where a window ends over which both are known.
        """

        known: Annotated[Scalar, ""]
        counts: Annotated[Scalar, ""]
        early: Annotated[Scalar, ""]
        angle_sum: Annotated[Scalar, "rad"]
        speed_residual: Annotated[Scalar, "rad/s"]
        speed_sum: Annotated[Scalar, "rad/s"]
        sensor_gain: Annotated[Scalar, "rad"]
        observer_gain: Annotated[Scalar, "rad"]
        complete: Annotated[Scalar, ""]
        angle_alarm: Annotated[Scalar, ""]
        speed_alarm: Annotated[Scalar, ""]
        backwards_alarm: Annotated[Scalar, ""]
        stuck_alarm: Annotated[Scalar, ""]
        backwards_sum: Annotated[Scalar, ""]
        turned_meanwhile: Annotated[Scalar, "rad"]

    def init(self) -> State:
        """State before the first sample."""
        return self.State(
            self.gate.init(),
            self.increments.init(),
            self.stuck.init(),
            self.backwards.init(),
            self.angle.init(),
            self.speed.init(),
        )

    def step(self, state: State, sample: SensorBesideObserver) -> tuple[State, Output]:
        """Process one sample."""
        gate, gated = self.gate.step(state.gate, sample)
        residual = sample.estimate.angle_residual_electrical
        angle, summed = self.angle.step(state.angle, residual, enabled=gated.counts)
        increments, gained = self.increments.step(state.increments, sample)
        gained = gained._replace(complete=where(gated.known, gained.complete, 0.0))
        faster = (gained.sensor - gained.observer) / self.increments.window
        speed, speeds = self.speed.step(state.speed, faster, enabled=gained.complete)
        against_it = -sign(gained.sensor * gained.observer)
        backwards, against = self.backwards.step(state.backwards, against_it, enabled=gained.complete)
        stuck, still = self.stuck.step(state.stuck, sample, enabled=gated.known)
        return self.State(gate, increments, stuck, backwards, angle, speed), self.Output(
            gated.known,
            gated.counts,
            where(gate.elapsed < self.gate.start, 1.0, 0.0),
            maximum(summed.up, summed.down),
            where(gained.complete, faster, 0.0),
            maximum(speeds.up, speeds.down),
            gained.sensor,
            gained.observer,
            gained.complete,
            summed.alarm,
            speeds.alarm,
            against.alarm,
            still.alarm,
            against.up,
            still.turned,
        )
