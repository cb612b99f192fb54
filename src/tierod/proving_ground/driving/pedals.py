"""Speed keeping: the foot of whoever drives, on accelerator and brake."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.graph.maths import both, limit, minimum, where
from tierod.ranges import NOT_NEGATIVE, POSITIVE


class Foot(NamedTuple):
    """What the foot remembers: the acceleration that gradients and drag have asked for, and the one pressed now."""

    learnt: Any
    pressed: Any


@dataclass(frozen=True)
class Pedals:
    """Keeps a target speed: its planned acceleration ahead, proportional and integral action on the speed error.

    With the defaults the closed loop has both poles near -0.5 1/s. Where the target is zero and the car has almost
    stopped, the foot rests on the brake until the target rises.

    Args:
        proportional: acceleration per speed error
        integral: growth of acceleration per speed error
        learnt_limit: of what the integral can reach: a gradient of 20 %, drag at high speed
        foot_time: lag of the foot
        strongest_acceleration, strongest_braking: what is asked for at the most
        holding: deceleration that would result from the brake's force at rest
        resting_speed: below it, the target at zero, the brake is held
    """

    proportional: Annotated[float, "1/s", POSITIVE] = 1.0
    integral: Annotated[float, "1/s**2", NOT_NEGATIVE] = 0.25
    learnt_limit: Annotated[float, "m/s**2", NOT_NEGATIVE] = 2.0
    foot_time: Annotated[float, "s", POSITIVE] = 0.15
    strongest_acceleration: Annotated[float, "m/s**2", POSITIVE] = 5.0
    strongest_braking: Annotated[float, "m/s**2", POSITIVE] = 9.0
    holding: Annotated[float, "m/s**2", POSITIVE] = 3.0
    resting_speed: Annotated[float, "m/s", POSITIVE] = 0.3

    def remembered(self) -> Foot:
        """At ease."""
        return Foot(0.0, 0.0)

    def press(self, foot: Foot, speed: Any, wanted_speed: Any, planned: Any, step: Any) -> tuple[Foot, Any]:
        """Once a step: the foot afterwards, and the acceleration [m/s**2] that it asks of the car.

        Args:
            foot: before
            speed: forward speed [m/s]
            wanted_speed: target [m/s]
            planned: acceleration of the target [m/s**2]
            step: [s]
        """
        error = wanted_speed - speed
        asked = planned + self.proportional * error + foot.learnt
        wanted = limit(asked, -self.strongest_braking, self.strongest_acceleration)
        resting = both(wanted_speed < 0.5 * self.resting_speed, speed < self.resting_speed)
        wanted = where(resting, minimum(wanted, -self.holding), wanted)
        learning = where(both(wanted == asked, speed >= self.resting_speed), self.integral * error, 0.0)
        learnt = limit(foot.learnt + step * learning, -self.learnt_limit, self.learnt_limit)
        pressed = foot.pressed + step / self.foot_time * (wanted - foot.pressed)
        return Foot(learnt, pressed), pressed
