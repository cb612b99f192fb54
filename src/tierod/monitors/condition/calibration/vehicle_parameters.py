"""Parameters of a vehicle from a few minutes of fault-free driving, by maximum likelihood of the healthy filter."""

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
"""What is looked for; all else of the vehicle stays as its file says."""

SOURCE = "calibrated on healthy driving"
LEAST_SECONDS = 60.0
"""Shortest drive that separates all parameters [s]; five minutes are better."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A vehicle, and how its parameters were found.

    Args:
        vehicle: with the values found, their standard deviations and `SOURCE`
        found: where the search ended
    """

    vehicle: Vehicle
    found: Found


def calibrate(
    recordings: Sequence[Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Fit the parameters of a vehicle to fault-free drives.

    The values of the vehicle file count as known before, with their standard deviations. What a filter else learns
    slowly on the way (offsets, difference of the wheels) is held, so that it goes into the parameters.

    Args:
        recordings: of fault-free driving, with bends, braking and both directions
        vehicle: where to start from
        progress: called with the share that is done

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
    """Free parameters: one rear wheel alone does not identify the difference between both."""
    both = all(any(np.isfinite(each[:, wheel]).any() for each in drives) for wheel in range(2))
    return tuple(name for name in FREE if both or name != "wheel_speed_difference")


def _calibrated(vehicle: Vehicle, found: Found) -> Vehicle:
    parameters = dict(vehicle.parameters)
    for name, value, deviation in zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True):
        parameters[name] = Parameter(name, value, parameters[name].unit, deviation, SOURCE)
    return replace(vehicle, parameters=parameters)
