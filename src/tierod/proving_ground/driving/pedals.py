"""Speed keeping: the foot of whoever drives, on accelerator and brake."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import NOT_NEGATIVE, POSITIVE, SHARE
from tierod.core.graph.maths import both, limit, minimum, where

STANDING = 0.02
"""Speed below which a car counts as standing [m/s]."""


class Foot(NamedTuple):
    """What the foot remembers, as accelerations [m/s**2].

    Args:
        learnt: what gradients and drag have asked for
        pressed: what is pressed now
        resting: least braking of a halting car, which grows until it stands
    """

    learnt: Any
    pressed: Any
    resting: Any


@dataclass(frozen=True)
class Pedals:
    """Keeps a target speed: its planned acceleration ahead, proportional and integral action on the speed error.

    With the defaults the closed loop has both poles near -0.5 1/s. The slower the car, the lighter the foot brakes: a
    stop is eased, since the tyres throw a car back that is stopped at once. Where the target is zero and the car has
    almost stopped, the foot rests on the brake until the target rises.

    Args:
        proportional: acceleration per speed error
        integral: growth of acceleration per speed error
        learnt_limit: of what the integral can reach: a gradient of 20 %, drag at high speed
        foot_time: lag of the foot
        strongest_acceleration, strongest_braking: what is asked for at the most
        easing_speed: below it braking becomes the lighter
        last_share: of the braking that is left at the end of a stop
        holding: deceleration that would result from the brake's force at rest
        resting_speed: below it, the target at zero, the foot comes to rest on the brake
        resting_rate: at which its weight grows while the car still rolls
    """

    proportional: Annotated[float, "1/s", POSITIVE] = 1.0
    integral: Annotated[float, "1/s**2", NOT_NEGATIVE] = 0.25
    learnt_limit: Annotated[float, "m/s**2", NOT_NEGATIVE] = 2.0
    foot_time: Annotated[float, "s", POSITIVE] = 0.15
    strongest_acceleration: Annotated[float, "m/s**2", POSITIVE] = 5.0
    strongest_braking: Annotated[float, "m/s**2", POSITIVE] = 9.0
    easing_speed: Annotated[float, "m/s", POSITIVE] = 0.8
    last_share: Annotated[float, "", SHARE] = 0.2
    holding: Annotated[float, "m/s**2", POSITIVE] = 3.0
    resting_speed: Annotated[float, "m/s", POSITIVE] = 0.3
    resting_rate: Annotated[float, "m/s**3", POSITIVE] = 3.0

    def remembered(self) -> Foot:
        """At ease."""
        return Foot(0.0, 0.0, 0.0)

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
        asked = self._eased(planned + self.proportional * error, speed) + foot.learnt
        wanted = limit(asked, -self.strongest_braking, self.strongest_acceleration)
        halting = both(wanted_speed < 0.5 * self.resting_speed, speed < self.resting_speed)
        resting = where(halting, self._resting(foot, speed, step), 0.0)
        wanted = where(halting, minimum(wanted, -resting), wanted)
        learning = where(both(wanted == asked, speed >= self.resting_speed), self.integral * error, 0.0)
        learnt = limit(foot.learnt + step * learning, -self.learnt_limit, self.learnt_limit)
        pressed = foot.pressed + step / self.foot_time * (wanted - foot.pressed)
        return Foot(learnt, pressed, resting), pressed

    def _eased(self, acceleration: Any, speed: Any) -> Any:
        """Braking at walking pace becomes lighter; anything else stays [m/s**2]."""
        share = self.last_share + (1.0 - self.last_share) * limit(speed / self.easing_speed, 0.0, 1.0)
        return where(acceleration < 0.0, share * acceleration, acceleration)

    def _resting(self, foot: Foot, speed: Any, step: Any) -> Any:
        """Weight of the foot on the brake [m/s**2]: all of it at rest, growing until then."""
        growing = minimum(foot.resting + step * self.resting_rate, self.holding)
        return where(speed < STANDING, self.holding, growing)
