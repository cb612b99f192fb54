"""Control units beside the assist: of an angle, of the speed, of a variable ratio and of the steering feel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import exp, limit, where
from tierod.physics.gear import variable_gain


class AngleMemory(NamedTuple):
    """State of the control from step to step.

    Args:
        angle, target: of the step before [rad]
        rate, target_rate: filtered [rad/s]
        integral: torque learnt from lasting resistance [N*m]
    """

    angle: Scalar
    target: Scalar
    rate: Scalar
    target_rate: Scalar
    integral: Scalar


@dataclass(frozen=True)
class AngleControl:
    """Proportional, integral and derivative action on an angle, with the target's rate and its damping ahead.

    Rates come from differences of the angles behind one low-pass for both. The integral rests while the torque is at
    its limit.

    Args:
        stiffness: torque per angle error
        damping: torque per rate error
        integral: growth of torque per angle error
        forward_damping: torque per rate of the target
        torque_limit: of the request
        rate_time: of the low-pass on the rates
        step_time: between two decisions
    """

    stiffness: Annotated[float, "N*m/rad", POSITIVE]
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE]
    integral: Annotated[float, "N*m/rad/s", NOT_NEGATIVE]
    torque_limit: Annotated[float, "N*m", POSITIVE]
    forward_damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.0
    rate_time: Annotated[float, "s", POSITIVE] = 2e-3
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> AngleMemory:
        """At rest, straight ahead."""
        return AngleMemory(0.0, 0.0, 0.0, 0.0, 0.0)

    def decide(self, memory: AngleMemory, target: Scalar, angle: Scalar) -> tuple[AngleMemory, Scalar]:
        """Requested torque [N*m], once a step.

        Args:
            memory: of the step before
            target: wanted angle [rad]
            angle: sensed angle [rad]
        """
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
    """Planned acceleration ahead, proportional and integral action on the speed error; the memory is the integral.

    The integral rests while the acceleration is at its limit.

    Args:
        proportional: acceleration per speed error
        integral: growth of acceleration per speed error
        greatest_acceleration: asked for in either direction
        step_time: between two decisions
    """

    proportional: Annotated[float, "1/s", POSITIVE] = 1.5
    integral: Annotated[float, "1/s**2", NOT_NEGATIVE] = 0.4
    greatest_acceleration: Annotated[float, "m/s**2", POSITIVE] = 3.0
    step_time: Annotated[float, "s", POSITIVE] = 1e-3

    def remembered(self) -> float:
        """Nothing learnt yet [m/s**2]."""
        return 0.0

    def decide(self, memory: Scalar, target: Scalar, planned: Scalar, speed: Scalar) -> tuple[Scalar, Scalar]:
        """Memory, and the acceleration that is asked for [m/s**2], once a step.

        Args:
            memory: of the step before
            target: speed [m/s]
            planned: acceleration of the target [m/s**2]
            speed: sensed [m/s]
        """
        error = target - speed
        asked = planned + self.proportional * error + memory
        given = limit(asked, -self.greatest_acceleration, self.greatest_acceleration)
        return memory + where(given == asked, self.step_time * self.integral * error, 0.0), given


@dataclass(frozen=True)
class VariableRatio:
    """Turn of the pinion per turn of the steering wheel: direct when parking, indirect at high speed.

    The gain falls from `standing` to `fast`, see `tierod.physics.gear.variable_gain`.

    Args:
        standing: at rest; 1.45 makes a ratio of 15.5 into 10.7
        fast: at very high speed; 0.78 makes it 20
        middle_speed: where the gain is half way
    """

    standing: Annotated[float, "", POSITIVE] = 1.45
    fast: Annotated[float, "", POSITIVE] = 0.78
    middle_speed: Annotated[float, "m/s", POSITIVE] = 18.0

    def gain(self, speed: Scalar) -> Scalar:
        """Gain [-] at a speed [m/s]."""
        return variable_gain(speed, self.standing, self.fast, self.middle_speed)


@dataclass(frozen=True)
class Feel:
    """Torque of the feedback motor: a spring to the middle, damping, and a share of what the road actuator does.

    Args:
        stiffness: torque per angle of the steering wheel
        damping: torque per rate of the steering wheel
        load_share: torque at the steering wheel per torque of the road actuator's motor
        torque_limit: of the request
    """

    stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 0.8
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.15
    load_share: Annotated[float, "", NOT_NEGATIVE] = 30.0
    torque_limit: Annotated[float, "N*m", POSITIVE] = 8.0

    def torque(self, angle: Scalar, rate: Scalar, actuator_torque: Scalar) -> Scalar:
        """Request for the feedback motor [N*m], against the hands.

        Args:
            angle, rate: of the steering wheel [rad], [rad/s]
            actuator_torque: of the road actuator at its shaft [N*m]
        """
        wanted = -self.stiffness * angle - self.damping * rate - self.load_share * actuator_torque
        return limit(wanted, -self.torque_limit, self.torque_limit)
