"""Control units other than the assist: angle control, speed control, variable ratio and steering feel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import exp, limit, where
from tierod.physics.gear import variable_gain


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

    The gain falls from `standing` to `fast`, see `tierod.physics.gear.variable_gain`.
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
