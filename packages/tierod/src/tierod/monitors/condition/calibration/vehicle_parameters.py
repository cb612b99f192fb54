"""Estimation of a vehicle's parameters from minutes of fault-free driving, by the likelihood of its filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import InputError
from tierod.core.recording import Recording
from tierod.monitors.condition.calibration.grid import RATE, aligned, moving
from tierod.monitors.condition.calibration.likeliest import Found, Search
from tierod.vehicles import Parameter, Vehicle

FREE = (
    "mass",
    "yaw_inertia",
    "front_cornering_stiffness",
    "rear_cornering_stiffness",
    "tyre_friction",
    "relaxation_length",
    "pneumatic_trail",
    "rolling_resistance",
    "column_inertia",
    "rack_damping",
    "rack_stiffness",
    "nominal_friction",
    "column_friction_angle",
    "roll_share",
    "wheel_speed_scale",
    "wheel_speed_difference",
    "yaw_rate_offset",
    "steering_wheel_angle_offset",
    "steering_shaft_torque_offset",
    "tie_rod_force_offset",
    "longitudinal_acceleration_offset",
    "lateral_acceleration_offset",
)
"""Free parameters of the estimation; all others keep their values of the vehicle file."""

SOURCE = "calibrated on healthy driving"
LEAST_SECONDS = 60.0
"""Shortest driving time with which all parameters are identifiable [s]; five minutes are better."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Vehicle with estimated parameters.

    Args:
        vehicle: vehicle with the estimates, their standard deviations and `SOURCE`
        found: result of the search
    """

    vehicle: Vehicle
    found: Found


def calibrate(
    recordings: Sequence[Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Fit the parameters of a vehicle to fault-free drives.

    The values of the vehicle file with their standard deviations are the prior. Offsets and wheel differences, which
    the filter otherwise estimates as slow states, are held constant, so that the parameters take them.

    Args:
        recordings: recordings of fault-free driving, with bends to both sides, accelerating and braking
        vehicle: start of the search and prior
        progress: called with the completed share, 0 to 1

    Raises:
        InputError: less than a minute of driving, or a vehicle file without standard deviations
    """
    drives = [aligned(each) for each in recordings]
    driven = sum(int(moving(each).sum()) for each in drives) / RATE
    if driven < LEAST_SECONDS:
        raise InputError(
            f"the recordings hold {driven:.0f} s of driving; calibration needs {LEAST_SECONDS:.0f} s, better five "
            "minutes with bends to both sides, accelerating and braking"
        )
    found = Search(vehicle, drives, _free(drives)).run(progress)
    return Calibration(_calibrated(vehicle, found), found)


def _free(drives: Sequence[np.ndarray]) -> tuple[str, ...]:
    """Free parameters; with one rear wheel alone the difference between both is not identifiable."""
    both = all(any(np.isfinite(each[:, wheel]).any() for each in drives) for wheel in range(2))
    return tuple(name for name in FREE if both or name != "wheel_speed_difference")


def _calibrated(vehicle: Vehicle, found: Found) -> Vehicle:
    parameters = dict(vehicle.parameters)
    for name, value, deviation in zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True):
        parameters[name] = Parameter(name, value, parameters[name].unit, deviation, SOURCE)
    return replace(vehicle, parameters=parameters)
