"""Tests of the motor's angle sensor: beside the observer, of its electrical signals, and beside its target."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE, check_ranges
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    arctan2,
    both,
    cos,
    greatest_of,
    hypot,
    log,
    maximum,
    minimum,
    negated,
    present,
    sign,
    sin,
    where,
)
from tierod.methods.detectors.control_charts import Cusum, Debounce
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleSample
from tierod.physics.motor import wrapped

# CUSUM of the electrical angle residual, one value per millisecond [rad]: see docs/explanation/motor-angle.md, Design
# of the CUSUM.
ANGLE_DRIFT, ANGLE_THRESHOLD = 0.044, 0.9
# CUSUM of the speed residual, one value per 10 ms [rad/s]: see the same section.
SPEED_DRIFT, SPEED_THRESHOLD = 0.5, 2.0
# Excess of windows against the observer over those with it that shows swapped sine and cosine, or phases [-].
BACKWARDS = 3.0


class SensorBesideObserver(NamedTuple):
    """Estimate of the observer, and the sensor's reading."""

    estimate: MotorAngleObserver.Output  # output of the observer
    motor_angle_mechanical: Annotated[Scalar, "rad"]  # reading of the sensor; NaN where the sample has none


class Window(NamedTuple):
    """Increments over the present window, and sensor and observer since the sensor stands still."""

    last: Annotated[Scalar, "rad"]  # last reading
    begun: Annotated[Scalar, ""]  # 1 after the first reading
    gained: Annotated[Scalar, "rad"]  # increment of the sensor
    start: Annotated[Scalar, "rad"]  # observer at the start of the window
    elapsed: Annotated[Scalar, "s"]
    stood: Annotated[Scalar, ""]  # 1 where the motor stood meanwhile
    still_sensor: Annotated[Scalar, "rad"]
    still_observer: Annotated[Scalar, "rad"]
    stuck: Annotated[Scalar, ""]


@dataclass(frozen=True)
class SensorComparison:
    """Comparison of the sensor with the observer: CUSUMs of the differences of angle and speed, and two more tests.

    The difference is known where the currents determine the angle well; one value per millisecond counts. Increments of
    both over short windows are compared in direction and scale; a window that begins or ends with a standing motor does
    not count. A sensor that does not move while the observer turns is stuck.
    """

    pole_pairs: Annotated[float, "", POSITIVE]  # pole pairs of the motor [-]
    nominal_flux: Annotated[float, "V*s", POSITIVE]  # flux of its magnets, from the vehicle file [V s]
    sample_time: Annotated[float, "s", POSITIVE] = 1e-4  # sampling interval [s]
    # least electrical speed [rad/s]; below it an uncertain resistance hides the back-EMF
    least_speed: Annotated[float, "rad/s", POSITIVE] = 40.0
    # largest standard deviation of the observer's mechanical angle [rad]
    most_deviation: Annotated[float, "rad", POSITIVE] = 0.03
    hold: Annotated[float, "s", NOT_NEGATIVE] = 0.02  # time for which all conditions must hold [s]
    start: Annotated[float, "s", NOT_NEGATIVE] = 5.0  # time in which the observer learns resistance and flux [s]
    # largest logarithm of the flux over the nominal one [-]; magnets from -40 to 120 degrees stay within 10 % of their
    # flux: beyond, the observer has not settled, and magnets so weak are a fault of their own
    widest_flux: Annotated[float, "", POSITIVE] = 0.2
    # spacing of the values that count [s]; closer residuals are not independent
    spacing: Annotated[float, "s", POSITIVE] = 1e-3
    # window of the increments, long against the sensor's noise, short against a reversal [s]
    window: Annotated[float, "s", POSITIVE] = 0.01
    # least mean speed of the observer over a window, mechanical [rad/s]
    least_mean_speed: Annotated[float, "rad/s", POSITIVE] = 10.0
    # range within which a sensor has not moved [rad]; four times its noise and step
    still: Annotated[float, "rad", POSITIVE] = 0.006
    # turn of the observer meanwhile, mechanical [rad]; far more than its error
    travel: Annotated[float, "rad", POSITIVE] = 0.15
    # CUSUM of windows in which the sensor turns against the observer, less those with it
    backwards: Cusum = field(default_factory=lambda: Cusum(0.0, BACKWARDS, BACKWARDS, "upper"))
    # angle, speed: CUSUMs of the differences of angle and of speed
    angle: Cusum = field(default_factory=lambda: Cusum(ANGLE_DRIFT, ANGLE_THRESHOLD, 2.0 * ANGLE_THRESHOLD))
    speed: Cusum = field(default_factory=lambda: Cusum(SPEED_DRIFT, SPEED_THRESHOLD, 2.0 * SPEED_THRESHOLD))
    holding: Debounce = field(init=False, repr=False)

    Sample = SensorBesideObserver

    class State(NamedTuple):
        elapsed: Annotated[Scalar, "s"]
        since: Annotated[Scalar, "s"]
        held: Debounce.State
        window: Window
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        window = Window(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
        sums = self.backwards.init(), self.angle.init(), self.speed.init()
        return self.State(0.0, self.spacing, self.holding.init(), window, *sums)

    def step(self, state: State, sample: SensorBesideObserver) -> tuple[State, Output]:
        elapsed = minimum(state.elapsed + self.sample_time, self.start + self.sample_time)
        held, known, since, counts = self._gated(state, elapsed, sample)
        angle, summed = self.angle.step(state.angle, sample.estimate.angle_residual_electrical, enabled=counts)
        window, gained, turned, ended = self._increments(state.window, sample)
        complete = where(known, ended, 0.0)
        faster = (gained - turned) / self.window
        speed, speeds = self.speed.step(state.speed, faster, enabled=complete)
        backwards, against = self.backwards.step(state.backwards, -sign(gained * turned), enabled=complete)
        window, meanwhile = self._standing(state.window, window, sample, known)
        return self.State(elapsed, since, held, window, backwards, angle, speed), self.Output(
            known,
            counts,
            where(elapsed < self.start, 1.0, 0.0),
            maximum(summed.up, summed.down),
            where(complete, faster, 0.0),
            maximum(speeds.up, speeds.down),
            gained,
            turned,
            complete,
            summed.alarm,
            speeds.alarm,
            against.alarm,
            window.stuck,
            against.up,
            meanwhile,
        )

    def _gated(
        self, state: State, elapsed: Scalar, sample: SensorBesideObserver
    ) -> tuple[Debounce.State, Scalar, Scalar, Scalar]:
        """Debounced gate, whether the difference is known, time since a value counted, and whether this one does."""
        half, seen = 0.5 * self.sample_time, sample.estimate
        good = all_of(
            elapsed + half > self.start,
            self.pole_pairs * absolute(seen.motor_speed) > self.least_speed,
            seen.standing < 0.5,
            seen.motor_angle_standard_deviation < self.most_deviation,
            absolute(log(maximum(seen.motor_flux / self.nominal_flux, 1e-6))) < self.widest_flux,
        )
        held, debounced = self.holding.step(state.held, where(good, 1.0, 0.0))
        known = both(debounced.active, good)
        since = minimum(state.since + self.sample_time, self.spacing)
        counts = all_of(known, present(sample.motor_angle_mechanical), since + half > self.spacing)
        return held, where(known, 1.0, 0.0), where(counts, 0.0, since), where(counts, 1.0, 0.0)

    def _increments(self, old: Window, sample: SensorBesideObserver) -> tuple[Window, Scalar, Scalar, Scalar]:
        """The window after a sample, increments of sensor and observer, and whether a whole window has ended."""
        fresh, seen = present(sample.motor_angle_mechanical), sample.estimate
        reading = where(fresh, sample.motor_angle_mechanical, old.last)
        gained = old.gained + where(both(fresh, old.begun), wrapped(reading - old.last), 0.0)
        elapsed = minimum(old.elapsed + self.sample_time, 10.0 * self.window)
        stood = where(seen.standing, 1.0, old.stood)
        ends = both(fresh, elapsed + 0.5 * self.sample_time > self.window)
        turned = seen.motor_angle - old.start
        moved = absolute(turned) > self.least_mean_speed * self.window
        complete = all_of(ends, stood < 0.5, elapsed < 2.0 * self.window, moved)
        after = old._replace(
            last=reading,
            begun=where(fresh, 1.0, old.begun),
            gained=where(ends, 0.0, gained),
            start=where(ends, seen.motor_angle, old.start),
            elapsed=where(ends, 0.0, elapsed),
            stood=where(ends, where(seen.standing, 1.0, 0.0), stood),
        )
        return after, gained, turned, where(complete, 1.0, 0.0)

    def _standing(
        self, old: Window, window: Window, sample: SensorBesideObserver, enabled: Scalar
    ) -> tuple[Window, Scalar]:
        """The window with the test of a stuck sensor, and the turn of the observer while it stands still."""
        fresh, seen = present(sample.motor_angle_mechanical), sample.estimate
        moved = all_of(fresh, absolute(wrapped(window.last - old.still_sensor)) > self.still)
        anew = any_of(both(fresh, old.begun < 0.5), moved, seen.standing > 0.5, negated(enabled))
        sensor = where(both(anew, fresh), sample.motor_angle_mechanical, old.still_sensor)
        observer = where(anew, seen.motor_angle, old.still_observer)
        turned = where(old.begun, seen.motor_angle - observer, 0.0)
        stuck = where(anew, 0.0, where(both(fresh, absolute(turned) > self.travel), 1.0, old.stuck))
        return window._replace(still_sensor=sensor, still_observer=observer, stuck=stuck), turned


LEARNT = 0.2  # initial time over which the amplitude of sine and cosine is averaged [s]


class ElectricalAlarms(NamedTuple):
    """1 while a check fails, 0 while it passes or its inputs are missing."""

    supply_low: Annotated[Scalar, ""]  # supply of the controller too low
    angle_timeout: Annotated[Scalar, ""]  # no reading of the angle for too long
    angle_gradient: Annotated[Scalar, ""]  # a step that no motor can make
    resolver_amplitude: Annotated[Scalar, ""]  # sine and cosine have left their initial circle
    resolver_mismatch: Annotated[Scalar, ""]  # the angle differs from that of its sine and cosine
    current_sum: Annotated[Scalar, ""]  # phase currents do not add up to zero
    # current_saturated, voltage_saturated: a signal stands still at its peak while the motor turns
    current_saturated: Annotated[Scalar, ""]
    voltage_saturated: Annotated[Scalar, ""]


class ElectricalFigures(NamedTuple):
    """Statistics that the checks compare with their limits; 0 where an input is missing."""

    angle_age: Annotated[Scalar, "s"]  # age of the last reading of the angle
    angle_step: Annotated[Scalar, ""]  # step between two readings, over the largest that a motor can make
    resolver_amplitude: Annotated[Scalar, ""]  # amplitude over the initial one, less one
    resolver_mismatch: Annotated[Scalar, "rad"]  # electrical angle less that of sine and cosine
    current_sum: Annotated[Scalar, "A"]  # sum of the phase currents
    # same_current, same_voltage: longest standstill of a current or a voltage at a peak, in samples, while the motor
    # turned
    same_current: Annotated[Scalar, ""]
    same_voltage: Annotated[Scalar, ""]


class Clipped(NamedTuple):
    """A signal, the number of samples for which it has stood still away from zero, and the angle at their start."""

    last: Annotated[Scalar, ""]
    same: Annotated[Scalar, ""]
    since: Annotated[Scalar, "rad"]


@dataclass(frozen=True)
class ElectricalChecks:
    """Checks of range, gradient, timeout, amplitude, sums and saturation."""

    pole_pairs: Annotated[float, "", POSITIVE]  # pole pairs of the motor [-]
    sample_time: Annotated[float, "s", POSITIVE] = 1e-4  # sampling interval [s]
    # supply below which the inverter of a 12 V system may not reach its voltage [V]
    least_supply: Annotated[float, "V", POSITIVE] = 9.0
    # longest time without a reading of the angle, ten frames of a millisecond [s]
    longest_gap: Annotated[float, "s", POSITIVE] = 0.01
    # largest speed of the motor, twice that at which the back-EMF equals the supply [rad/s]
    greatest_speed: Annotated[float, "rad/s", POSITIVE] = 600.0
    # additional step of the angle, for noise and resolution [rad]
    step_margin: Annotated[float, "rad", POSITIVE] = 0.02
    amplitude_margin: Annotated[float, "", POSITIVE] = 0.15  # share by which the amplitude may change [-]
    # largest mismatch of the electrical angle: noise of both, and half a sample at full speed [rad]
    greatest_mismatch: Annotated[float, "rad", POSITIVE] = 0.06
    # largest sum of the phase currents, ten times the noise of one [A]
    greatest_sum: Annotated[float, "A", POSITIVE] = 3.0
    # least_peak_current, least_peak_voltage: values below which nothing saturates [A], [V]
    least_peak_current: Annotated[float, "A", POSITIVE] = 2.0
    least_peak_voltage: Annotated[float, "V", POSITIVE] = 1.0
    # number of equal samples that noise rules out without saturation [-]
    same_samples: Annotated[float, "", POSITIVE] = 20.0
    # electrical turn meanwhile, over which the top of a sine falls by 3 %, more than a converter's step [rad]
    least_turn: Annotated[float, "rad", POSITIVE] = 0.5
    hold: Annotated[float, "s", POSITIVE] = 0.01  # time for which a check must fail [s]
    holding: Debounce = field(init=False, repr=False)

    Sample = MotorAngleSample

    class Output(NamedTuple):
        alarms: ElectricalAlarms
        figures: ElectricalFigures

    class State(NamedTuple):
        angle: Annotated[Scalar, "rad"]
        age: Annotated[Scalar, "s"]
        begun: Annotated[Scalar, ""]
        amplitude: Annotated[Scalar, "V"]
        learnt: Annotated[Scalar, "s"]
        mismatched: Annotated[Scalar, ""]
        clipped: tuple[Clipped, ...]
        held: tuple[Debounce.State, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        fresh = Clipped(0.0, 0.0, 0.0)
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (fresh,) * 7, (self.holding.init(),) * 4)

    def step(self, state: State, sample: MotorAngleSample) -> tuple[State, Output]:
        age, timeout, gradient, leap = self._angle(state, sample)
        amplitude, learnt, strange, mismatched, resolver = self._resolver(state, sample)
        total = sample.motor_current_a + sample.motor_current_b + sample.motor_current_c
        conditions = (
            (sample.supply_voltage < self.least_supply, present(sample.supply_voltage)),
            strange,
            (mismatched, 1.0),
            (absolute(total) > self.greatest_sum, present(total)),
        )
        steps = [
            self.holding.step(held, where(fails, 1.0, 0.0), enabled=known)
            for held, (fails, known) in zip(state.held, conditions, strict=True)
        ]
        low, strange_now, mismatch_now, sum_now = (out.active for _, out in steps)
        clipped, (current, voltage), same = self._saturation(state, sample)
        fresh = present(sample.motor_angle_mechanical)
        after = self.State(
            where(fresh, sample.motor_angle_mechanical, state.angle),
            age,
            where(fresh, 1.0, state.begun),
            amplitude,
            learnt,
            mismatched,
            clipped,
            tuple(held for held, _ in steps),
        )
        alarms = ElectricalAlarms(low, timeout, gradient, strange_now, mismatch_now, sum_now, current, voltage)
        summed = where(present(total), total, 0.0)
        return after, self.Output(alarms, ElectricalFigures(age, leap, *resolver, summed, *same))

    def _angle(self, state: State, sample: MotorAngleSample) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Age of the last reading, timeout, leap of the new reading, and its step over the largest possible one."""
        fresh = present(sample.motor_angle_mechanical)
        waited = minimum(state.age + self.sample_time, 1.0)
        age = where(fresh, 0.0, waited)
        timeout = both(state.begun, age > self.longest_gap)
        step = absolute(wrapped(where(fresh, sample.motor_angle_mechanical, state.angle) - state.angle))
        longest = minimum(self.greatest_speed * waited, 0.5 * math.pi) + self.step_margin
        leaps = where(all_of(fresh, state.begun, step > longest), 1.0, 0.0)
        return where(state.begun, age, 0.0), where(timeout, 1.0, 0.0), leaps, where(state.begun, step / longest, 0.0)

    def _resolver(
        self, state: State, sample: MotorAngleSample
    ) -> tuple[Scalar, Scalar, tuple[Scalar, Scalar], Scalar, tuple[Scalar, Scalar]]:
        """Learnt amplitude and learning time; wrong amplitude and whether judged; angle mismatch; both statistics."""
        there = both(present(sample.resolver_sine), present(sample.resolver_cosine))
        sine, cosine = where(there, sample.resolver_sine, 0.0), where(there, sample.resolver_cosine, 0.0)
        size = hypot(sine, cosine)
        learning = both(there, state.learnt < LEARNT)
        learnt = state.learnt + where(learning, self.sample_time, 0.0)
        share = self.sample_time / maximum(learnt, self.sample_time)
        amplitude = state.amplitude + where(learning, share * (size - state.amplitude), 0.0)
        strange = absolute(size - amplitude) > self.amplitude_margin * amplitude
        known = both(there, present(sample.motor_angle_mechanical))
        angle = self.pole_pairs * where(known, sample.motor_angle_mechanical, 0.0)
        # Cross and dot product with the resolver vector need neither unwrapping nor a division by its amplitude.
        across = sine * cos(angle) - cosine * sin(angle)
        along = sine * sin(angle) + cosine * cos(angle)
        mismatch = any_of(along < 0.0, absolute(across) > self.greatest_mismatch * size)
        judged = both(there, negated(learning))
        change = where(both(judged, amplitude > 0.0), size / maximum(amplitude, 1e-12) - 1.0, 0.0)
        apart = where(both(known, size > 0.0), arctan2(across, along), 0.0)
        mismatched = where(known, mismatch, state.mismatched)
        return amplitude, learnt, (strange, judged), mismatched, (change, apart)

    def _saturation(
        self, state: State, sample: MotorAngleSample
    ) -> tuple[tuple[Clipped, ...], tuple[Scalar, Scalar], tuple[Scalar, Scalar]]:
        """Signals that stand still, saturation of a current or voltage, and the longest standstill of each."""
        names = (
            "current_alpha",
            "current_beta",
            "current_a",
            "current_b",
            "current_c",
            "voltage_alpha",
            "voltage_beta",
        )
        fresh = present(sample.motor_angle_mechanical)
        angle = where(fresh, sample.motor_angle_mechanical, state.angle)
        clipped, flags, counts = [], [], []
        for old, name in zip(state.clipped, names, strict=True):
            value = getattr(sample, f"motor_{name}")
            there = present(value)
            least = self.least_peak_current if name.startswith("current") else self.least_peak_voltage
            here = both(absolute(value) > least, absolute(value - old.last) < 1e-9)
            same = where(there, where(here, minimum(old.same + 1.0, self.same_samples), 0.0), old.same)
            since = where(there, where(here, old.since, angle), old.since)
            turned = self.pole_pairs * absolute(wrapped(angle - since))
            clipped.append(Clipped(where(there, value, old.last), same, since))
            counts.append(where(turned > self.least_turn, same, 0.0))
            flags.append(counts[-1] > self.same_samples - 0.5)
        saturated = where(any_of(*flags[:5]), 1.0, 0.0), where(any_of(*flags[5:]), 1.0, 0.0)
        return tuple(clipped), saturated, (greatest_of(*counts[:5]), greatest_of(*counts[5:]))


@dataclass(frozen=True)
class NotFollowing:
    """Alarm for a sensor that stays away from its target: the drive has stalled, and its currents give no angle.

    A sensor that is stuck, or whose sine and cosine are swapped, makes the current control hold the rotor; so does a
    blocked motor. This test cannot separate them.
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4  # sampling interval [s]
    # largest following error of a fault-free drive, with a margin [rad]
    widest: Annotated[float, "rad", POSITIVE] = 1.0
    hold: Annotated[float, "s", POSITIVE] = 0.02  # time for which the error must be larger [s]
    # the same time where currents and voltages confirm the sensor [s]; a load beyond the motor's torque, or a target
    # beyond its speed, is not a fault while it passes
    confirmed_hold: Annotated[float, "s", POSITIVE] = 0.5
    # least change of a target for the test [rad]; a smaller one is not the target of the control
    least_course: Annotated[float, "rad", POSITIVE] = 0.5
    holding: Debounce = field(init=False, repr=False)
    holding_on: Debounce = field(init=False, repr=False)

    Sample = MotorAngleSample

    class State(NamedTuple):
        target: Annotated[Scalar, "rad"]
        sensor: Annotated[Scalar, "rad"]
        seen_target: Annotated[Scalar, ""]
        seen_sensor: Annotated[Scalar, ""]
        first: Annotated[Scalar, "rad"]
        moved: Annotated[Scalar, ""]
        held: Debounce.State
        held_on: Debounce.State

    class Output(NamedTuple):
        error: Annotated[Scalar, "rad"]
        alarm: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, 0.0, self.sample_time))
        object.__setattr__(self, "holding_on", Debounce(self.confirmed_hold, 0.0, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        return self.State(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, self.holding.init(), self.holding_on.init())

    def step(self, state: State, sample: MotorAngleSample, confirmed: Scalar | bool = False) -> tuple[State, Output]:
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
