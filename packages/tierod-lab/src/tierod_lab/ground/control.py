"""Control units: assist, return and damping of the steering, control of angle, speed and feel."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import absolute, exp, limit, where
from tierod.physics.steering import assist_speed_factor, assist_torque, variable_gain


class AssistMemory(NamedTuple):
    """State of the unit between two steps."""

    driver_torque: Scalar  # torque of the previous step [N*m]
    filtered_torque: Scalar  # driver torque behind the lead filter [N*m]
    torque: Scalar  # requested torque at the column [N*m]


@dataclass(frozen=True)
class Characteristic:
    """The assist map, see `tierod.physics.steering.assist_torque`."""

    linear_gain: Annotated[float, "", NOT_NEGATIVE] = 2.0
    quadratic_gain: Annotated[float, "1/(N*m)", NOT_NEGATIVE] = 1.5
    dead_band: Annotated[float, "N*m", NOT_NEGATIVE] = 0.0
    half_speed: Annotated[float, "m/s", POSITIVE] = 15.0

    def torque(self, driver_torque: Scalar, speed: Scalar, maximum: Scalar) -> Scalar:
        """Assist at the column [N*m] for a driver torque [N*m] and a speed [m/s], up to a maximum [N*m]."""
        return assist_torque(
            driver_torque, speed, self.linear_gain, self.quadratic_gain, self.dead_band, self.half_speed, maximum
        )


@dataclass(frozen=True)
class ActiveReturn:
    """Torque that returns a released wheel to the centre: a proportional control of its rate; by default at most 3 N*m.

    Its share is 0 at rest, 1 at the best speed, less above it, and a half at the fade torque of the driver. Both the
    reference rate and the share are assumptions of ours; production units use angle and rate alike.
    """

    rate_gain: Annotated[float, "1/s", NOT_NEGATIVE] = 1.5
    maximum_rate: Annotated[float, "rad/s", POSITIVE] = 3.0
    gain: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1.0
    best_speed: Annotated[float, "m/s", POSITIVE] = 6.0
    fade_torque: Annotated[float, "N*m", POSITIVE] = 1.0

    def torque(self, angle: Scalar, rate: Scalar, speed: Scalar, driver_torque: Scalar) -> Scalar:
        """Torque at the column [N*m]."""
        relative, effort = absolute(speed) / self.best_speed, driver_torque / self.fade_torque
        share = 2.0 * relative / ((1.0 + relative * relative) * (1.0 + effort * effort))
        wanted = limit(-self.rate_gain * angle, -self.maximum_rate, self.maximum_rate)
        return share * (self.gain * (wanted - rate))


@dataclass(frozen=True)
class AssistUnit:
    """Assist by characteristic and speed, active return and damping; a control unit sampled at the step of the car.

    The driver torque passes a lead filter, without which a high gain makes the loop of torsion bar and motor unstable.
    Return and damping act on the rate below the torsion bar, which the unit computes from steering wheel and twist:
    with the rate above the bar they would excite it.
    """

    characteristic: Characteristic = field(default_factory=Characteristic)
    active_return: ActiveReturn = field(default_factory=ActiveReturn)
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.2
    damping_speed: Annotated[float, "m/s", POSITIVE] = 15.0
    lead_time: Annotated[float, "s", NOT_NEGATIVE] = 0.008
    lag_time: Annotated[float, "s", NOT_NEGATIVE] = 0.0005
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 60.0
    # limit of the request's rate of change, at the column; with a tenth of it, a wheel released under full assist would
    # keep oscillating
    torque_rate: Annotated[float, "N*m/s", POSITIVE] = 20e3
    bar_stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    motor_ratio: Annotated[float, "", POSITIVE] = 20.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> AssistMemory:
        return AssistMemory(0.0, 0.0, 0.0)

    def decide(
        self, memory: AssistMemory, driver_torque: Scalar, speed: Scalar, angle: Scalar, rate: Scalar
    ) -> tuple[AssistMemory, Scalar]:
        filtered = self._lead(memory, driver_torque)
        rate = rate - (driver_torque - memory.driver_torque) / (self.step_time * self.bar_stiffness)
        wanted = self.characteristic.torque(filtered, speed, self.maximum_torque)
        wanted = wanted + self.active_return.torque(angle, rate, speed, driver_torque)
        wanted = wanted - self.damping * (1.0 - assist_speed_factor(speed, self.damping_speed)) * rate
        wanted = limit(wanted, -self.maximum_torque, self.maximum_torque)
        most = self.torque_rate * self.step_time
        torque = limit(wanted, memory.torque - most, memory.torque + most)
        return AssistMemory(driver_torque, filtered, torque), torque / self.motor_ratio

    def _lead(self, memory: AssistMemory, driver_torque: Scalar) -> Scalar:
        step, lead, lag = self.step_time, 2.0 * self.lead_time, 2.0 * self.lag_time
        torque = (step + lead) * driver_torque + (step - lead) * memory.driver_torque
        return (torque + (lag - step) * memory.filtered_torque) / (step + lag)


class AssistInputs(NamedTuple):
    """Inputs of an assist unit."""

    driver_torque: Annotated[Scalar, "N*m"]
    vehicle_speed: Annotated[Scalar, "m/s"]
    steering_wheel_angle: Annotated[Scalar, "rad"]
    steering_wheel_rate: Annotated[Scalar, "rad/s"]


class AssistOutputs(NamedTuple):
    """Request of an assist unit, at the motor's shaft."""

    motor_target_torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class AssistController:
    """Assist unit of a car as a block."""

    unit: AssistUnit = field(default_factory=AssistUnit)

    Sample = AssistInputs

    def init(self) -> AssistMemory:
        return self.unit.remembered()

    def step(self, state: AssistMemory, sample: AssistInputs) -> tuple[AssistMemory, AssistOutputs]:
        memory, torque = self.unit.decide(state, *sample)
        return memory, AssistOutputs(torque)


class AngleMemory(NamedTuple):
    """State of the control between two steps."""

    angle: Scalar  # angle, target: values of the previous step [rad]
    target: Scalar
    rate: Scalar  # rate, target_rate: filtered rates [rad/s]
    target_rate: Scalar
    integral: Scalar  # integral part of the torque [N*m]


@dataclass(frozen=True)
class AngleControl:
    """PID control of an angle with feed-forward of the target rate.

    Rates are differences of the angles behind equal low-pass filters. The integral part stops while the torque is at
    its limit.
    """

    stiffness: Annotated[float, "N*m/rad", POSITIVE]
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE]
    integral: Annotated[float, "N*m/rad/s", NOT_NEGATIVE]
    torque_limit: Annotated[float, "N*m", POSITIVE]
    forward_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.0
    rate_time: Annotated[float, "s", POSITIVE] = 2e-3
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> AngleMemory:
        return AngleMemory(0.0, 0.0, 0.0, 0.0, 0.0)

    def decide(self, memory: AngleMemory, target: Scalar, angle: Scalar) -> tuple[AngleMemory, Scalar]:
        keep = exp(-self.step_time / self.rate_time)
        gain = (1.0 - keep) / self.step_time
        rate = keep * memory.rate + gain * (angle - memory.angle)
        target_rate = keep * memory.target_rate + gain * (target - memory.target)
        error = target - angle
        asked = self.stiffness * error + self.damping * (target_rate - rate) + memory.integral
        asked = asked + self.forward_damping * target_rate
        torque = limit(asked, -self.torque_limit, self.torque_limit)
        integral = memory.integral + where(torque == asked, self.step_time * self.integral * error, 0.0)
        return AngleMemory(angle, target, rate, target_rate, integral), torque


@dataclass(frozen=True)
class SpeedControl:
    """PI control of the speed with feed-forward of the planned acceleration; its state is the integral part.

    The integral part stops while the acceleration is at its limit.
    """

    proportional: Annotated[float, "1/s", POSITIVE] = 1.5
    integral: Annotated[float, "1/s**2", NOT_NEGATIVE] = 0.4
    greatest_acceleration: Annotated[float, "m/s**2", POSITIVE] = 3.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> float:
        return 0.0

    def decide(self, memory: Scalar, target: Scalar, planned: Scalar, speed: Scalar) -> tuple[Scalar, Scalar]:
        error = target - speed
        asked = planned + self.proportional * error + memory
        given = limit(asked, -self.greatest_acceleration, self.greatest_acceleration)
        return memory + where(given == asked, self.step_time * self.integral * error, 0.0), given


@dataclass(frozen=True)
class VariableRatio:
    """Gain of the steering over the speed: direct when parking, indirect at high speed.

    The gain falls from `standing` to `fast`, see `tierod.physics.steering.variable_gain`.
    """

    standing: Annotated[float, "", POSITIVE] = 1.45  # gain at rest; 1.45 turns a ratio of 15.5 into 10.7
    fast: Annotated[float, "", POSITIVE] = 0.78  # gain at very high speed; 0.78 turns it into 20
    middle_speed: Annotated[float, "m/s", POSITIVE] = 18.0

    def gain(self, speed: Scalar) -> Scalar:
        """Gain [-] at a speed [m/s]."""
        return variable_gain(speed, self.standing, self.fast, self.middle_speed)


@dataclass(frozen=True)
class Feel:
    """Torque of the feedback motor: a centring spring, damping, and a share of the road actuator's torque."""

    stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 0.8
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.15
    load_share: Annotated[float, "", NOT_NEGATIVE] = 30.0
    torque_limit: Annotated[float, "N*m", POSITIVE] = 8.0

    def torque(self, angle: Scalar, rate: Scalar, actuator_torque: Scalar) -> Scalar:
        """Requested torque of the feedback motor, which opposes the hands [N*m].

        Args:
            angle, rate: angle [rad] and rate [rad/s] of the steering wheel
            actuator_torque: shaft torque of the road actuator [N*m]
        """
        wanted = -self.stiffness * angle - self.damping * rate - self.load_share * actuator_torque
        return limit(wanted, -self.torque_limit, self.torque_limit)
