"""Position control of a steering's actuator: from a target angle to a torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import exp, limit, where


class AngleMemory(NamedTuple):
    """What the control keeps from step to step.

    Args:
        angle, target: of the step before [rad]
        rate, target_rate: filtered [rad/s]
        integral: torque that lasting resistance has taught [N*m]
    """

    angle: Any
    target: Any
    rate: Any
    target_rate: Any
    integral: Any


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

    def decide(self, memory: AngleMemory, target: Any, angle: Any) -> tuple[AngleMemory, Any]:
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
