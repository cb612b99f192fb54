"""Inputs and outputs of the residuals of the sensors, and the thresholds that they are compared with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar, named_tuple
from tierod.core.fields import ANY, NOT_NEGATIVE
from tierod.core.graph.maths import absolute
from tierod_lab.papers.condition.rules.parameters import SENSOR_RESIDUALS

SensorResiduals: Any = named_tuple(
    "SensorResiduals", [(each.name, Annotated[float, each.unit]) for each in SENSOR_RESIDUALS]
)
"""Residuals r1 to r19 in their units; zero where one is missing."""

SensorFlags: Any = named_tuple("SensorFlags", [(each.name, Annotated[float, ""]) for each in SENSOR_RESIDUALS])
"""Presence of r1 to r19 as flags, 1.0 or 0.0."""


class Motion(NamedTuple):
    """Estimates of the models and filters of a residual set."""

    sideslip: Annotated[float, "rad"]  # sideslip angle at the centre of gravity, by the single-track model
    yaw_rate: Annotated[float, "rad/s"]  # yaw rate by the single-track model
    forward_speed: Annotated[float, "m/s"]  # forward speed by the two-stage filter
    torque: Annotated[float, "N*m"]  # torque, force: shaft torque and tie-rod force by the models of the steering
    force: Annotated[float, "N"]
    angle: Annotated[float, "rad"]  # steering wheel angle by rolling without slip
    # steering wheel angle by the balance of the steering, from torque and tie-rod force alone
    unmeasured_angle: Annotated[float, "rad"]


GROWTHS = ("per_speed", "per_yaw_acceleration", "per_lateral_acceleration", "per_steering_rate")
"""Fields of a threshold for the growth with each excitation, in the order of `Excitation`."""


class Excitation(NamedTuple):
    """Excitation of the drive, with which the errors of the models grow."""

    speed: Annotated[float, "m/s"]  # speed of the vehicle
    # yaw_acceleration, lateral_acceleration, steering_rate: signed; their magnitudes count
    yaw_acceleration: Annotated[float, "rad/s**2"]
    lateral_acceleration: Annotated[float, "m/s**2"]
    steering_rate: Annotated[float, "rad/s"]


@dataclass(frozen=True)
class ResidualThreshold:
    """Threshold of a residual, fixed or as an affine function of the excitation."""

    # threshold without excitation; alone it is a fixed threshold
    base: Annotated[float, "unit of the signal", NOT_NEGATIVE]
    # per_speed, per_yaw_acceleration, per_lateral_acceleration, per_steering_rate: growth with the excitation, in the
    # unit of the residual over that of the excitation
    per_speed: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_yaw_acceleration: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_lateral_acceleration: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    per_steering_rate: Annotated[float, "unit of the signal", NOT_NEGATIVE] = 0.0
    centre: Annotated[float, "unit of the signal", ANY] = 0.0  # fault-free value of the residual, with its sign

    @property
    def adapts(self) -> bool:
        """Whether the threshold grows with any excitation."""
        return any(getattr(self, name) > 0.0 for name in GROWTHS)

    def ratio(self, residual: Scalar, excitation: Excitation) -> Scalar:
        """Signed ratio of the residual, less its centre, to the threshold."""
        return (residual - self.centre) / self.at(excitation)

    def at(self, excitation: Excitation) -> Scalar:
        """Threshold at an excitation, in the unit of the residual."""
        return (
            self.base
            + self.per_speed * absolute(excitation.speed)
            + self.per_yaw_acceleration * absolute(excitation.yaw_acceleration)
            + self.per_lateral_acceleration * absolute(excitation.lateral_acceleration)
            + self.per_steering_rate * absolute(excitation.steering_rate)
        )
