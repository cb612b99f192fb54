"""What turns below the torsion bar, where the driver's torque is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class BelowBarParameters:
    """Constants of the steering, named as in a vehicle file, split at the torsion bar.

    The torque in the bar turns what is below it; inertia and damping of the steering wheel are the hands' to overcome.

    Args:
        column_inertia: of everything, at the steering wheel axis [kg m^2]
        column_damping: of everything, at the steering wheel axis [N m s/rad]
        steering_wheel_inertia: part of it above the bar [kg m^2]
        steering_wheel_damping: part of it above the bar [N m s/rad]
        torsion_bar_stiffness: [N m/rad]; infinite for a rigid bar
    """

    column_inertia: Annotated[float, "kg*m**2"]
    column_damping: Annotated[float, "N*m*s/rad"]
    steering_wheel_inertia: Annotated[float, "kg*m**2"] = 0.0
    steering_wheel_damping: Annotated[float, "N*m*s/rad"] = 0.0
    torsion_bar_stiffness: Annotated[float, "N*m/rad"] = math.inf

    @property
    def inertia(self) -> float:
        """Below the bar [kg m^2]."""
        return self.column_inertia - self.steering_wheel_inertia

    @property
    def damping(self) -> float:
        """Below the bar [N m s/rad]."""
        return self.column_damping - self.steering_wheel_damping
