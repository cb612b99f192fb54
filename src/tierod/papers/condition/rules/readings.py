"""Inputs and outputs of the residuals of the sensors, and the thresholds that they are compared with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, named_tuple
from tierod.core.fields import ANY, NOT_NEGATIVE
from tierod.core.graph.maths import absolute
from tierod.papers.condition.rules.catalogue import SENSOR_RESIDUALS

SensorResiduals: Any = named_tuple(
    "SensorResiduals", [(each.name, Annotated[float, each.unit]) for each in SENSOR_RESIDUALS]
)
"""r1 to r19 in their units; zero where one is not there."""

SensorFlags: Any = named_tuple("SensorFlags", [(each.name, Annotated[float, ""]) for each in SENSOR_RESIDUALS])
"""One flag (1.0 or 0.0) for each of r1 to r19."""


class Motion(NamedTuple):
    """Estimates of the filters of the set.

    Args:
        sideslip: at the centre of gravity
        yaw_rate: that the single track expects
        forward_speed: of the two-stage filter
        torque, force, angle: that the steering and rolling without slip expect
        unmeasured_angle: of the steering, from torque and tie-rod force alone
    """

    sideslip: Annotated[float, "rad"]
    yaw_rate: Annotated[float, "rad/s"]
    forward_speed: Annotated[float, "m/s"]
    torque: Annotated[float, "N*m"]
    force: Annotated[float, "N"]
    angle: Annotated[float, "rad"]
    unmeasured_angle: Annotated[float, "rad"]


GROWTHS = ("per_speed", "per_yaw_acceleration", "per_lateral_acceleration", "per_steering_rate")
"""Fields of a threshold that grow with the excitations, in their order."""


class Excitation(NamedTuple):
    """Excitation: the more there is of it, the worse the models follow.

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

    def ratio(self, residual: Scalar, excitation: Excitation) -> Scalar:
        """Residual from its centre in thresholds, with its sign."""
        return (residual - self.centre) / self.at(excitation)

    def at(self, excitation: Excitation) -> Scalar:
        """The threshold now, in the unit of the residual."""
        return (
            self.base
            + self.per_speed * absolute(excitation.speed)
            + self.per_yaw_acceleration * absolute(excitation.yaw_acceleration)
            + self.per_lateral_acceleration * absolute(excitation.lateral_acceleration)
            + self.per_steering_rate * absolute(excitation.steering_rate)
        )
