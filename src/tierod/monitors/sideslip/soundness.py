"""Which cars the observers of the paper can follow, and in what steps."""

from __future__ import annotations

import math

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import linearise
from tierod.models.steered_vehicle import SteeredVehicle
from tierod.monitors.sideslip.observer import LowSpeed

MOST = 1.8
"""Size of an eigenvalue times the step up to which the method of integration decays (it would grow from two on)."""


def require_sound(p: SteeredVehicle.Parameters, sample_time: float) -> None:
    """Refuse a car that the observers cannot follow.

    Args:
        p: of the car
        sample_time: [s]

    Raises:
        ParameterError: no trail, so that no torque tells of the tyres; or a motion too fast for the step, with its
            eigenvalue
    """
    trail = p.mechanical_trail + p.pneumatic_trail
    if not trail * p.front_cornering_stiffness > 0.0:
        raise ParameterError(
            f"mechanical_trail and pneumatic_trail together are {trail:g} m and front_cornering_stiffness is "
            f"{p.front_cornering_stiffness:g} N/rad: the aligning torque then does not show sideslip_angle; "
            "both must be above zero"
        )
    if not 0.0 < sample_time <= 0.1:
        raise ParameterError(f"the sample time is {sample_time} s; expected more than 0 and at most 0.1 s")
    step = sample_time / finer_steps(sample_time)
    system = linearise(SteeredVehicle, p, (0.0,) * 4, (0.0, LowSpeed.slowest))
    fastest = max(np.linalg.eigvals(system.A), key=abs)
    if abs(fastest) * step > MOST:
        raise ParameterError(
            f"at {LowSpeed.slowest:g} m/s the car has an eigenvalue of {fastest.real:.4g} 1/s, too fast for steps of "
            f"{step:g} s; check road_wheel_inertia, road_wheel_damping, road_wheel_friction and yaw_inertia"
        )


def finer_steps(sample_time: float) -> int:
    """Steps of the integration within a sample: a millisecond each, at which the models are far from their limit."""
    return max(1, math.ceil(sample_time / 1e-3 - 1e-6))
