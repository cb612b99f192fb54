"""Speed control of an automated car."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit, where


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

    def decide(self, memory: Any, target: Any, planned: Any, speed: Any) -> tuple[Any, Any]:
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
