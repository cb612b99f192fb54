"""Steering ratio that depends on the speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.core.fields import POSITIVE
from tierod.physics.gear import variable_gain


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

    def gain(self, speed: Any) -> Any:
        """Gain [-] at a speed [m/s]."""
        return variable_gain(speed, self.standing, self.fast, self.middle_speed)
