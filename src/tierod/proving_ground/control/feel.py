"""What the hands feel at a steering wheel without a column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.core.fields import NOT_NEGATIVE, POSITIVE
from tierod.core.graph.maths import limit


@dataclass(frozen=True)
class Feel:
    """Torque of the feedback motor: a spring to the middle, damping, and a share of what the road actuator does.

    Args:
        stiffness: torque per angle of the steering wheel
        damping: torque per rate of the steering wheel
        load_share: torque at the steering wheel per torque of the road actuator's motor
        torque_limit: of the request
    """

    stiffness: Annotated[float, "N*m/rad", NOT_NEGATIVE] = 0.8
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 0.15
    load_share: Annotated[float, "", NOT_NEGATIVE] = 30.0
    torque_limit: Annotated[float, "N*m", POSITIVE] = 8.0

    def torque(self, angle: Any, rate: Any, actuator_torque: Any) -> Any:
        """Request for the feedback motor [N*m], against the hands.

        Args:
            angle, rate: of the steering wheel [rad], [rad/s]
            actuator_torque: of the road actuator at its shaft [N*m]
        """
        wanted = -self.stiffness * angle - self.damping * rate - self.load_share * actuator_torque
        return limit(wanted, -self.torque_limit, self.torque_limit)
