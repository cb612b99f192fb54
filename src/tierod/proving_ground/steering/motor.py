"""The electric motor of a steering, with its current control as a lag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from tierod.graph.maths import limit
from tierod.physics.torque_ripple import torque_ripple
from tierod.ranges import NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class Ripple:
    """Torque that varies with the rotor's angle, see `tierod.physics.torque_ripple`; typical of a good EPS motor."""

    cogging_torque: Annotated[float, "N*m", NOT_NEGATIVE] = 0.01
    share: Annotated[float, "", NOT_NEGATIVE] = 0.01
    order: Annotated[float, "", POSITIVE] = 24.0


@dataclass(frozen=True)
class Motor:
    """A motor at its shaft; typical of a mid-size car with 60 N*m of assist at the column.

    Args:
        ratio: turns of the rotor per turn of the pinion
        inertia: of the rotor
        damping: viscous, of the rotor's bearings and eddy currents
        lag: time constant of the current control, whose bandwidth is about 80 Hz
        maximum_torque: what the current limit allows
        ripple: None for a smooth motor
    """

    ratio: Annotated[float, "", POSITIVE] = 20.0
    inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.5e-4
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 1e-3
    lag: Annotated[float, "s", POSITIVE] = 2e-3
    maximum_torque: Annotated[float, "N*m", POSITIVE] = 3.5
    ripple: Ripple | None = None

    def torque_rate(self, torque: Any, request: Any) -> Any:
        """Rate of change [N*m/s] of the torque of the currents under a request [N*m]."""
        return (limit(request, -self.maximum_torque, self.maximum_torque) - torque) / self.lag

    def shaft_torque(self, torque: Any, angle: Any) -> Any:
        """Torque at the shaft [N*m] at an angle of the rotor [rad]."""
        if self.ripple is None:
            return torque
        return torque + torque_ripple(angle, torque, self.ripple.cogging_torque, self.ripple.share, self.ripple.order)
