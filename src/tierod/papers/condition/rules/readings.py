"""What the residuals of the sensors take in and give out."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from tierod.core.block import named_tuple
from tierod.papers.condition.rules.catalogue import SENSOR_RESIDUALS

SensorResiduals: Any = named_tuple(
    "SensorResiduals", [(each.name, Annotated[float, each.unit]) for each in SENSOR_RESIDUALS]
)
"""r1 to r19 in their units; zero where one is not there."""

SensorFlags: Any = named_tuple("SensorFlags", [(each.name, Annotated[float, ""]) for each in SENSOR_RESIDUALS])
"""One flag (1.0 or 0.0) for each of r1 to r19."""


class Motion(NamedTuple):
    """What the filters of the set say of the vehicle.

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
