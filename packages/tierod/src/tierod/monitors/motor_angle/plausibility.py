"""Plausibility of the angles of motor, steering wheel and pinion, and isolation of the wrong one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import (
    absolute,
    all_of,
    any_of,
    both,
    limit,
    maximum,
    minimum,
    negated,
    present,
    select,
    where,
)
from tierod.methods.detectors.control_charts import Debounce
from tierod.monitors.motor_angle.observer import MotorAngleSample
from tierod.physics.motor import wrapped
from tierod.physics.steering import superposed_angle, superposed_target, variable_gain

# Codes of the suspected angle; the last one means the steering wheel's or the pinion's.
NONE, MOTOR, WHEEL, PINION, NOT_MOTOR = 0.0, 1.0, 2.0, 3.0, 4.0


@dataclass(frozen=True)
class WhichAngle:
    """Code of the wrong one of the motor's, the steering wheel's and the pinion's angle.

    The observer is further evidence: since the mismatch began it has agreed with the motor's sensor, or not. If not,
    the motor's angle is wrong. If so, one of the other two is: the one isolated by motion; or the steering wheel's,
    where the motor deviates from the variable ratio's target for the recorded angle. Otherwise the wrong one of the two
    is unknown: a control that reads the same wrong wheel angle follows it.
    """

    sample_time: Annotated[float, "s", POSITIVE] = 1e-4  # sampling interval [s]
    # mismatch of the three from which it has begun, at the pinion [rad]; half of the alarm limit
    greatest: Annotated[float, "rad", POSITIVE] = 0.01
    # largest electrical residual in agreement [rad]; ten standard deviations of a fault-free one
    agreement: Annotated[float, "rad", POSITIVE] = 0.1
    # excess of residuals in agreement over those not, or the reverse, for a decision [-]
    needed: Annotated[float, "", POSITIVE] = 20.0
    # largest deviation of the motor from its target, at the pinion [rad]; following error of a fault-free drive
    widest_detour: Annotated[float, "rad", POSITIVE] = 0.04
    hold: Annotated[float, "s", POSITIVE] = 0.05  # time for which the deviation must be larger [s]
    holding: Debounce = field(init=False, repr=False)

    class State(NamedTuple):
        apart: Annotated[Scalar, ""]
        by_motion: Annotated[Scalar, ""]
        score: Annotated[Scalar, ""]
        held: Debounce.State

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        return self.State(0.0, NONE, 0.0, self.holding.init())

    def decided(
        self, state: State, seen: AnglePlausibility.Output, residual: Scalar, counts: Scalar
    ) -> tuple[State, Scalar]:
        """State after a sample and code of the wrong angle, by the motor's electrical residual where it counts."""
        apart = where(absolute(seen.mismatch) > self.greatest, 1.0, 0.0)
        begins = all_of(apart > 0.5, state.apart < 0.5)
        opinion = where(absolute(residual) < self.agreement, 1.0, -1.0)
        score = where(begins, 0.0, state.score) + where(counts > 0.5, opinion, 0.0)
        score = limit(score, -2.0 * self.needed, 2.0 * self.needed)
        held, detour = self.holding.step(state.held, where(absolute(seen.detour) > self.widest_detour, 1.0, 0.0))
        # The evidence by motion is taken when the alarm comes; later the motion itself depends on the fault.
        unknown = any_of(begins, state.by_motion < 0.5)
        by_motion = where(unknown, where(seen.alarm > 0.5, seen.by_motion, NONE), state.by_motion)
        elsewhere = any_of(absolute(by_motion - WHEEL) < 0.5, absolute(by_motion - PINION) < 0.5)
        other = where(elsewhere, by_motion, where(detour.active, WHEEL, NOT_MOTOR))
        decided = where(score <= -self.needed, MOTOR, where(score >= self.needed, other, by_motion))
        after = self.State(apart, by_motion, score, held)
        return after, where(seen.alarm > 0.5, decided, NONE)


@dataclass(frozen=True)
class Superposition:
    """The gear of an active front steering, named as in a vehicle file."""

    superposition_motor_ratio: Annotated[float, ""]  # turns of the motor per turn of the pinion, i_M [-]
    # turns of the steering wheel's shaft per turn of the pinion, i_D [-]
    superposition_input_ratio: Annotated[float, ""]
    # stiffness of the bar between gear and pinion, twisted by the driver's torque [N m/rad]
    torsion_bar_stiffness: Annotated[float, "N*m/rad"]


@dataclass(frozen=True)
class VariableGain:
    """Turn that the superposition adds to the steering wheel's, over the speed; named as in a vehicle file."""

    # superposition_gain_standing, superposition_gain_fast: turn of the pinion over that without motor [-]
    superposition_gain_standing: Annotated[float, ""]
    superposition_gain_fast: Annotated[float, ""]
    # speed at which the gain is half way between both [m/s]
    superposition_gain_speed: Annotated[float, "m/s", POSITIVE]


class Held(NamedTuple):
    """Last reading of a slow signal, and its age [s]; an age of 1 means no reading yet, later ages stay below 1."""

    value: Annotated[Scalar, ""]
    age: Annotated[Scalar, "s"]

    def after(self, value: Scalar, time: Scalar) -> Held:
        fresh = present(value)
        older = where(self.age < 1.0, minimum(self.age + time, 0.999), self.age)
        return Held(where(fresh, value, self.value), where(fresh, 0.0, older))


class Moved(NamedTuple):
    """An angle at its own shaft: last reading, last step, and travel since the angles last agreed."""

    last: Annotated[Scalar, "rad"]
    step: Annotated[Scalar, "rad"]
    travel: Annotated[Scalar, "rad"]

    def after(self, value: Scalar, compares: Scalar, agrees: Scalar) -> Moved:
        step = value - self.last
        new = Moved(value, step, where(agrees, 0.0, self.travel + absolute(step)))
        return select(compares, new, self)


@dataclass(frozen=True)
class AnglePlausibility:
    """Alarm for a pinion that is not where motor and steering wheel put it.

    The angle that stood still while the mismatch grew, or that jumped with it, is suspected; `which` decides. The
    initial mismatch of the three angles is taken as their zeros.

    Args:
        sample_time: sampling interval [s]
        greatest: largest mismatch at the pinion [rad]; resolution of the slow angles, and their different ages in turns
        hold: time for which the mismatch must be larger [s]
        learning: number of readings from which the zeros are taken [-]
        longest_gap: largest age of angles and torques that are compared [s]
        gain: gain of the superposition over the speed; None where the vehicle file does not give it
        which: isolation of the wrong angle, with the motor's observer as further evidence

    Where the gain is known, the motor is also compared with its target for the steering wheel's angle: a deviation that
    grows while motor and pinion otherwise agree shows that the recorded steering wheel angle is wrong.

    Source: Reinelt et al., eqs (1) and (4); the twist of the torsion bar, which the paper omits, is added: under
    4 N m it turns the pinion by more than the motor does at 13 degrees.
    """

    gear: Superposition
    sample_time: Annotated[float, "s", POSITIVE] = 1e-4
    greatest: Annotated[float, "rad", POSITIVE] = 0.02
    hold: Annotated[float, "s", POSITIVE] = 0.05
    learning: Annotated[float, "", POSITIVE] = 50.0
    longest_gap: Annotated[float, "s", POSITIVE] = 0.05
    gain: VariableGain | None = None
    which: WhichAngle = field(default_factory=WhichAngle)
    holding: Debounce = field(init=False, repr=False)

    Sample = MotorAngleSample

    class State(NamedTuple):
        motor: Held
        turned: Annotated[Scalar, "rad"]
        wheel: Held
        torque: Held
        speed: Annotated[Scalar, "m/s"]
        moved: tuple[Moved, Moved, Moved]
        readings: Annotated[Scalar, ""]
        zero: Annotated[Scalar, "rad"]
        mismatch: Annotated[Scalar, "rad"]
        jumped: Annotated[Scalar, ""]
        detour_zero: Annotated[Scalar, "rad"]
        detour: Annotated[Scalar, "rad"]
        held: Debounce.State
        which: WhichAngle.State

    class Output(NamedTuple):
        """Pinion angle less that of the other two, whether the mismatch is too large, and the code of the wrong angle.

        The detour is the pinion angle from the motor less that from the gain over the speed; 0 where unknown.
        `by_motion` is the angle that stood still or jumped; `suspect` also takes the motor's observer into account.
        """

        mismatch: Annotated[Scalar, "rad"]
        alarm: Annotated[Scalar, ""]
        by_motion: Annotated[Scalar, ""]
        detour: Annotated[Scalar, "rad"]
        suspect: Annotated[Scalar, ""]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        unread, still = Held(0.0, 1.0), Moved(0.0, 0.0, 0.0)
        return self.State(
            motor=unread,
            turned=0.0,
            wheel=unread,
            torque=unread,
            speed=-1.0,
            moved=(still, still, still),
            readings=0.0,
            zero=0.0,
            mismatch=0.0,
            jumped=NONE,
            detour_zero=0.0,
            detour=0.0,
            held=self.holding.init(),
            which=self.which.init(),
        )

    def step(
        self, state: State, sample: MotorAngleSample, residual: Scalar = 0.0, counts: Scalar = 0.0
    ) -> tuple[State, Output]:
        motor = state.motor.after(sample.motor_angle_mechanical, self.sample_time)
        followed = both(present(sample.motor_angle_mechanical), state.motor.age < 1.0)
        turned = state.turned + where(followed, wrapped(motor.value - state.motor.value), 0.0)
        torque = state.torque.after(sample.driver_torque, self.sample_time)
        wheel = state.wheel.after(sample.steering_wheel_angle, self.sample_time)
        speed = where(present(sample.vehicle_speed), sample.vehicle_speed, state.speed)
        recent = (each.age < self.longest_gap for each in (motor, wheel, torque))
        compares = all_of(present(sample.pinion_angle), *recent)
        pinion = where(compares, sample.pinion_angle, state.moved[2].last)
        raw = pinion - self._expected(turned, wheel.value, torque.value)
        learning = both(compares, state.readings < self.learning)
        readings = state.readings + where(learning, 1.0, 0.0)
        zero = state.zero + where(learning, (raw - state.zero) / maximum(readings, 1.0), 0.0)
        ready = both(compares, readings > self.learning - 0.5)
        mismatch = where(ready, raw - zero, state.mismatch)
        agrees = absolute(mismatch) < 0.25 * self.greatest
        angles = zip(state.moved, (turned, wheel.value, pinion), strict=True)
        hub, hands, below = (old.after(value, compares, agrees) for old, value in angles)
        moved = (hub, hands, below)
        jumped = self._jumped(state, moved, where(ready, mismatch - state.mismatch, 0.0), agrees)
        held, out = self.holding.step(state.held, where(absolute(mismatch) > self.greatest, 1.0, 0.0))
        by_motion = where(out.active, where(jumped > 0.5, jumped, self._still(moved)), NONE)
        off = self._detour(turned, wheel.value, speed)
        detour_zero = state.detour_zero + where(learning, (off - state.detour_zero) / maximum(readings, 1.0), 0.0)
        detour = where(both(ready, speed > -0.5), off - detour_zero, state.detour)
        seen = self.Output(mismatch, out.active, by_motion, detour, NONE)
        which, suspect = self.which.decided(state.which, seen, residual, counts)
        after = self.State(
            motor=motor,
            turned=turned,
            wheel=wheel,
            torque=torque,
            speed=speed,
            moved=moved,
            readings=readings,
            zero=zero,
            mismatch=mismatch,
            jumped=jumped,
            detour_zero=detour_zero,
            detour=detour,
            held=held,
            which=which,
        )
        return after, seen._replace(suspect=suspect)

    def _expected(self, motor: Scalar, wheel: Scalar, torque: Scalar) -> Scalar:
        g = self.gear
        superposed = superposed_angle(motor, wheel, g.superposition_motor_ratio, g.superposition_input_ratio)
        return superposed - torque * g.superposition_input_ratio / g.torsion_bar_stiffness

    def _detour(self, motor: Scalar, wheel: Scalar, speed: Scalar) -> Scalar:
        if self.gain is None:
            return 0.0
        ratios = self.gear.superposition_motor_ratio, self.gear.superposition_input_ratio
        names = self.gain.superposition_gain_standing, self.gain.superposition_gain_fast
        wanted = variable_gain(maximum(speed, 0.0), *names, self.gain.superposition_gain_speed)
        return (motor - superposed_target(wheel, wanted, *ratios)) / ratios[0]

    def _still(self, now: tuple[Moved, ...]) -> Scalar:
        """The only angle that has not moved since all agreed, while the others have."""
        sizes = [m.travel / ratio for m, ratio in zip(now, self._ratios(), strict=True)]
        still = [size < 0.1 * self.greatest for size in sizes]
        alone = [all_of(still[k], *(sizes[j] > 0.5 * self.greatest for j in range(3) if j != k)) for k in range(3)]
        return where(alone[0], MOTOR, where(alone[1], WHEEL, where(alone[2], PINION, NONE)))

    def _jumped(self, state: State, now: tuple[Moved, ...], change: Scalar, agrees: Scalar) -> Scalar:
        """The angle whose step changed by as much as the mismatch, if that was a jump."""
        pairs = zip(now, state.moved, self._ratios(), strict=True)
        kinks = [absolute(new.step - old.step) / ratio for new, old, ratio in pairs]
        most = maximum(kinks[0], maximum(kinks[1], kinks[2]))
        which = where(kinks[0] >= most, MOTOR, where(kinks[1] >= most, WHEEL, PINION))
        jumps = both(absolute(change) > 0.6 * self.greatest, most > 0.6 * absolute(change))
        # The first jump counts until the angles agree again: later motion itself depends on the fault.
        first = both(jumps, state.jumped < 0.5)
        return where(first, which, where(both(agrees, negated(jumps)), NONE, state.jumped))

    def _ratios(self) -> tuple[Scalar, Scalar, Scalar]:
        return self.gear.superposition_motor_ratio, self.gear.superposition_input_ratio, 1.0
