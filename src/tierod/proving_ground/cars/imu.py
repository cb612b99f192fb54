"""Where the inertial sensors of a virtual car sit, and what they therefore feel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.physics.gravity import GRAVITY
from tierod.physics.single_track import lateral_acceleration_at
from tierod.proving_ground.parts import Reaction


@dataclass(frozen=True)
class InertialUnit:
    """Mounting place of the inertial unit on the body; typically on the tunnel, below the centre of gravity.

    Args:
        forward, left, up: from the centre of gravity of the car, about which its body rolls
    """

    forward: Annotated[float, "m"] = 0.2
    left: Annotated[float, "m"] = 0.0
    up: Annotated[float, "m"] = -0.15

    def lateral_acceleration(self, reaction: Reaction) -> Any:
        """Specific force across the body [m/s**2], with lever arm, bank and the lean of the body."""
        at_place = lateral_acceleration_at(
            reaction.lateral_acceleration, reaction.yaw_acceleration, reaction.yaw_rate, self.forward, self.left
        )
        return at_place - self.up * reaction.roll_acceleration + GRAVITY * reaction.roll_angle

    def longitudinal_acceleration(self, reaction: Reaction) -> Any:
        """Specific force along the body [m/s**2], with lever arm and grade."""
        turning = reaction.yaw_rate * reaction.yaw_rate * self.forward + reaction.yaw_acceleration * self.left
        return reaction.longitudinal_acceleration - turning
