"""The elastic bar between steering wheel and column, and the steering wheel above it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.physics.steering_ratio import torsion_bar_torque


class Wheel(NamedTuple):
    """Motion of the steering wheel, where a torsion bar parts it from the column."""

    angle: Any
    rate: Any


@dataclass(frozen=True)
class TorsionBar:
    """An elastic bar below the steering wheel; 140 N*m/rad is 2.4 N*m per degree."""

    stiffness: Annotated[float, "N*m/rad", POSITIVE] = 140.0
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.05

    def torque(self, wheel: Wheel, angle: Any, rate: Any) -> Any:
        """Torque on the column [N*m]."""
        return torsion_bar_torque(wheel.angle, angle, self.stiffness, wheel.rate, rate, self.damping)
