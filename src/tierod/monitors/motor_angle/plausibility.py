"""Whether the angles of motor, steering wheel and pinion fit each other, and which of them does not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import POSITIVE, check_ranges
from tierod.core.graph.maths import absolute, all_of, both, maximum, minimum, negated, present, where
from tierod.methods.detectors.threshold import Debounce
from tierod.monitors.motor_angle.which_angle import MOTOR, NONE, PINION, WHEEL, WhichAngle
from tierod.physics.angle import wrapped
from tierod.physics.gear import superposed_angle, superposed_target, variable_gain


@dataclass(frozen=True)
class Superposition:
    """The gear of an active front steering, named as in a vehicle file.

    Args:
        superposition_motor_ratio: turns of the motor per turn of the pinion, i_M []
        superposition_input_ratio: turns of the steering wheel's shaft per turn of the pinion, i_D []
        torsion_bar_stiffness: between gear and pinion, which twists under the driver's torque [N m/rad]
    """

    superposition_motor_ratio: Annotated[float, ""]
    superposition_input_ratio: Annotated[float, ""]
    torsion_bar_stiffness: Annotated[float, "N*m/rad"]


@dataclass(frozen=True)
class VariableGain:
    """Over the speed, what the superposition adds to the turn of the steering wheel; named as in a vehicle file.

    Args:
        superposition_gain_standing, superposition_gain_fast: turn of the pinion over that without motor []
        superposition_gain_speed: at which it is half way between both [m/s]
    """

    superposition_gain_standing: Annotated[float, ""]
    superposition_gain_fast: Annotated[float, ""]
    superposition_gain_speed: Annotated[float, "m/s", POSITIVE]


class Angles(NamedTuple):
    """What is measured of the superposition at one instant, NaN where it is not."""

    motor_angle_mechanical: Annotated[float, "rad"]
    steering_wheel_angle: Annotated[float, "rad"]
    pinion_angle: Annotated[float, "rad"]
    driver_torque: Annotated[float, "N*m"]
    vehicle_speed: Annotated[float, "m/s"]


class Moved(NamedTuple):
    """An angle in turns of the pinion: last reading, last step, travel since the angles last agreed."""

    last: Any
    step: Any
    travel: Any


@dataclass(frozen=True)
class AnglePlausibility:
    """Alarm when the pinion is not where motor and steering wheel put it.

    The angle that stood still while the disagreement grew, or that jumped with it, is suspected; `which` decides. What
    the three disagree in at the start is taken as their zeros.

    Args:
        gear: ratios and stiffness
        sample_time: [s]
        greatest: disagreement at the pinion: resolution of the slow angles and their different age while turning [rad]
        hold: for so long [s]
        learning: readings from which the zeros are taken []
        longest_gap: angles and torques older than this are not compared [s]
        gain: of the superposition over the speed; None where the vehicle file does not tell it
        which: decides which angle is wrong, with the observer of the motor as a fourth opinion

    Where the gain is known, the motor is compared with what it wants of the steering wheel's angle, too: a detour that
    grows while motor and pinion agree otherwise tells the recorded angle of the wheel from the others.

    Source: Reinelt et al., eqs (1) and (4); the twist of the torsion bar, which the paper leaves out, is added: under
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

    Sample = Angles

    class State(NamedTuple):
        """Motor's last reading, travel and age; torque, its age; all angles; wheel, its age; zero; suspect; hold."""

        motor_last: Any
        motor_turned: Any
        motor_age: Any
        torque: Any
        torque_age: Any
        motor: Moved
        wheel: Moved
        pinion: Moved
        wheel_held: Any
        wheel_age: Any
        zero: Any
        readings: Any
        mismatch: Any
        jumped: Any
        held: Any
        speed: Any
        detour_zero: Any
        detour: Any

    class Output(NamedTuple):
        """Pinion less what the other two tell, whether that is too far, and the angle that is suspected (code).

        The detour is where the motor puts the pinion less where the gain over the speed wants it; 0 where unknown.
        """

        mismatch: Annotated[float, "rad"]
        alarm: Annotated[float, ""]
        suspect: Annotated[float, ""]
        detour: Annotated[float, "rad"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "holding", Debounce(self.hold, self.hold, self.sample_time))
        check_ranges(self)

    def init(self) -> State:
        """Nothing seen."""
        none = Moved(0.0, 0.0, 0.0)
        return self.State(
            0.0,
            0.0,
            1.0,
            0.0,
            1.0,
            none,
            none,
            none,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            NONE,
            self.holding.init(),
            -1.0,
            0.0,
            0.0,
        )

    def step(self, state: State, sample: Any) -> tuple[State, Output]:
        """One sample on; angles are compared where the pinion's brings a reading."""
        fresh, begun = present(sample.motor_angle_mechanical), state.motor_age < 1.0
        motor_last = where(fresh, sample.motor_angle_mechanical, state.motor_last)
        turned = state.motor_turned + where(both(fresh, begun), wrapped(motor_last - state.motor_last), 0.0)
        motor_age = where(fresh, 0.0, _aged(state.motor_age, self.sample_time, state.motor_age < 1.0))
        twisted = present(sample.driver_torque)
        torque = where(twisted, sample.driver_torque, state.torque)
        torque_age = where(twisted, 0.0, _aged(state.torque_age, self.sample_time, state.torque_age < 1.0))
        told = present(sample.steering_wheel_angle)
        wheel_age = where(told, 0.0, _aged(state.wheel_age, self.sample_time, state.wheel_age < 1.0))
        wheel = where(told, sample.steering_wheel_angle, state.wheel_held)
        ages = (motor_age, wheel_age, torque_age)
        compares = all_of(present(sample.pinion_angle), *(age < self.longest_gap for age in ages))
        pinion = where(compares, sample.pinion_angle, state.pinion.last)
        raw = pinion - self._told(turned, wheel, torque)
        learning = both(compares, state.readings < self.learning)
        readings = state.readings + where(learning, 1.0, 0.0)
        zero = state.zero + where(learning, (raw - state.zero) / maximum(readings, 1.0), 0.0)
        ready = both(compares, readings > self.learning - 0.5)
        mismatch = where(ready, raw - zero, state.mismatch)
        far = absolute(mismatch) > self.greatest
        agrees = absolute(mismatch) < 0.25 * self.greatest
        motor = _moved(state.motor, turned, compares, agrees)
        hands = _moved(state.wheel, wheel, compares, agrees)
        below = _moved(state.pinion, pinion, compares, agrees)
        now = (motor, hands, below)
        jumped = self._jumped(state, now, where(ready, mismatch - state.mismatch, 0.0), agrees)
        held, out = self.holding.step(state.held, where(far, 1.0, 0.0))
        suspect = where(out.active, where(jumped > 0.5, jumped, self._still(now)), NONE)
        speed = where(present(sample.vehicle_speed), sample.vehicle_speed, state.speed)
        off = self._detour(turned, wheel, speed)
        detour_zero = state.detour_zero + where(learning, (off - state.detour_zero) / maximum(readings, 1.0), 0.0)
        detour = where(both(ready, speed > -0.5), off - detour_zero, state.detour)
        after = self.State(
            motor_last,
            turned,
            motor_age,
            torque,
            torque_age,
            motor,
            hands,
            below,
            wheel,
            wheel_age,
            zero,
            readings,
            mismatch,
            jumped,
            held,
            speed,
            detour_zero,
            detour,
        )
        return after, self.Output(mismatch, out.active, suspect, detour)

    def _told(self, motor: Any, wheel: Any, torque: Any) -> Any:
        """Where motor and steering wheel put the pinion [rad]."""
        g = self.gear
        superposed = superposed_angle(motor, wheel, g.superposition_motor_ratio, g.superposition_input_ratio)
        return superposed - torque * g.superposition_input_ratio / g.torsion_bar_stiffness

    def _detour(self, motor: Any, wheel: Any, speed: Any) -> Any:
        """Where the motor puts the pinion less where the variable gain wants it [rad]."""
        if self.gain is None:
            return 0.0
        ratios = self.gear.superposition_motor_ratio, self.gear.superposition_input_ratio
        names = self.gain.superposition_gain_standing, self.gain.superposition_gain_fast
        wanted = variable_gain(maximum(speed, 0.0), *names, self.gain.superposition_gain_speed)
        return (motor - superposed_target(wheel, wanted, *ratios)) / ratios[0]

    def _still(self, now: tuple[Moved, ...]) -> Any:
        """The one angle that has not moved since all agreed, while another has."""
        sizes = [m.travel / ratio for m, ratio in zip(now, self._ratios(), strict=True)]
        still = [size < 0.1 * self.greatest for size in sizes]
        alone = [all_of(still[k], *(sizes[j] > 0.5 * self.greatest for j in range(3) if j != k)) for k in range(3)]
        return where(alone[0], MOTOR, where(alone[1], WHEEL, where(alone[2], PINION, NONE)))

    def _jumped(self, state: State, now: tuple[Moved, ...], change: Any, agrees: Any) -> Any:
        """The angle whose step changed by as much as the disagreement did, if that was a jump."""
        befores = (state.motor, state.wheel, state.pinion)
        kinks = [
            absolute(new.step - old.step) / ratio for new, old, ratio in zip(now, befores, self._ratios(), strict=True)
        ]
        most = maximum(kinks[0], maximum(kinks[1], kinks[2]))
        which = where(kinks[0] >= most, MOTOR, where(kinks[1] >= most, WHEEL, PINION))
        jumps = both(absolute(change) > 0.6 * self.greatest, most > 0.6 * absolute(change))
        first = both(jumps, state.jumped < 0.5)
        return where(first, which, where(both(agrees, negated(jumps)), NONE, state.jumped))

    def _ratios(self) -> tuple[Any, Any, Any]:
        return self.gear.superposition_motor_ratio, self.gear.superposition_input_ratio, 1.0


def _aged(age: Any, time: Any, begun: Any) -> Any:
    return where(begun, minimum(age + time, 0.999), age)


def _moved(old: Moved, value: Any, compares: Any, agrees: Any) -> Moved:
    step = value - old.last
    travel = where(agrees, 0.0, old.travel + absolute(step))
    return _chosen(compares, Moved(value, step, travel), old)


def _chosen(condition: Any, new: Moved, old: Moved) -> Moved:
    return Moved(*(where(condition, a, b) for a, b in zip(new, old, strict=True)))
