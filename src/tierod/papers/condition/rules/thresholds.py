"""Thresholds of residuals: fixed ones, and ones that widen with what the models cannot follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.graph.maths import absolute
from tierod.core.ranges import ANY, NOT_NEGATIVE

GROWTHS = ("per_speed", "per_yaw_acceleration", "per_lateral_acceleration", "per_steering_rate")
"""Fields of a threshold that grow with the excitations, in their order."""


class Excitation(NamedTuple):
    """What the models follow worse the more there is of it.

    Args:
        speed: of the vehicle
        yaw_acceleration, lateral_acceleration, steering_rate: their sizes count, not their signs
    """

    speed: Annotated[float, "m/s"]
    yaw_acceleration: Annotated[float, "rad/s**2"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    steering_rate: Annotated[float, "rad/s"]


@dataclass(frozen=True)
class ResidualThreshold:
    """Threshold of a residual as a sum of what it is at rest and what each excitation adds.

    Args:
        base: at no excitation; alone it is a fixed threshold
        per_speed, per_yaw_acceleration, per_lateral_acceleration, per_steering_rate: growth with each; in the unit of
            the residual over theirs
        centre: of the residual while all is well, with its sign
    """

    base: Annotated[float, "unit of the signal", NOT_NEGATIVE]
    per_speed: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_yaw_acceleration: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_lateral_acceleration: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_steering_rate: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    centre: Annotated[float, "unit of the signal", ANY] = 0.0

    @property
    def adapts(self) -> bool:
        """Whether it widens with anything."""
        return any(getattr(self, name) > 0.0 for name in GROWTHS)

    def ratio(self, residual: Any, excitation: Excitation) -> Any:
        """How many thresholds a residual is off its centre, with its sign."""
        return (residual - self.centre) / self.at(excitation)

    def at(self, excitation: Excitation) -> Any:
        """The threshold now, in the unit of the residual."""
        return (
            self.base
            + self.per_speed * absolute(excitation.speed)
            + self.per_yaw_acceleration * absolute(excitation.yaw_acceleration)
            + self.per_lateral_acceleration * absolute(excitation.lateral_acceleration)
            + self.per_steering_rate * absolute(excitation.steering_rate)
        )
