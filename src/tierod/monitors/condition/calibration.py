"""Parameters of a vehicle from a few minutes of healthy driving, by maximum likelihood of the healthy filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tierod.errors import InputError
from tierod.monitors.condition.likeliest import Found, Search
from tierod.monitors.condition.signals import ConditionSample
from tierod.recording import Recording
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
MAXIMUM_AGE = 0.006
"""A reading older than this is missing, as it is for the monitor: a held one would be one that stands still [s]."""
LEAST_SECONDS = 60.0
"""Shortest drive that tells all parameters apart [s]; five minutes are better."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found.

    Args:
        vehicle: with the values found, their standard deviations and `SOURCE`
        names: of the parameters that were looked for
        values, deviations: of them, in SI units
        before, after: mean log likelihood of a sample, without its constant
        squares: mean squared innovation over its variance of every reading, wheel speeds first; one where the filter
            knows what it does not know
        steps: of the search
        converged: whether it came to an end
    """

    vehicle: Vehicle
    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    before: float
    after: float
    squares: np.ndarray
    steps: int
    converged: bool


def calibrate(
    recordings: Sequence[Recording], vehicle: Vehicle, progress: Callable[[float], None] = lambda share: None
) -> Calibration:
    """Fit the parameters of a vehicle to healthy drives.

    The values of the vehicle file count as known before, with their standard deviations. What a filter else learns
    slowly on the way (offsets, difference of the wheels) is held, so that it goes into the parameters.

    Args:
        recordings: of healthy driving, with bends, braking and both directions
        vehicle: where to start from
        progress: called with the share that is done

    Raises:
        InputError: less than a minute of driving, or a vehicle of which nobody says how well it is known
    """
    drives = [aligned(each) for each in recordings]
    moving = sum(float(np.sum(np.abs(np.nan_to_num(each[:, 0])) > 1.0)) for each in drives) / 100.0
    if moving < LEAST_SECONDS:
        raise InputError(
            f"the recordings hold {moving:.0f} s of driving; calibration needs {LEAST_SECONDS:.0f} s, better five "
            "minutes with bends to both sides, accelerating and braking"
        )
    search = Search(vehicle, drives, FREE)
    found = search.run(progress)
    return Calibration(_calibrated(vehicle, search.names, found), search.names, *found)


def is_calibrated(vehicle: Vehicle) -> bool:
    """Whether somebody has measured what wheels and sensors of a vehicle read; else its filters know that they do not.

    Args:
        vehicle: with the parameters of `AutomatedVehicle`
    """
    return "wheel_speed_scale" in vehicle and not vehicle.parameters["wheel_speed_scale"].assumed


def aligned(recording: Recording, rate: float = 100.0) -> np.ndarray:
    """The samples of a recording, one row each.

    Args:
        recording: with the signals of `ConditionSample`; what is missing is NaN
        rate: of the rows [Hz]
    """
    return recording.align(ConditionSample._fields, rate, maximum_age=MAXIMUM_AGE).values


def _calibrated(vehicle: Vehicle, names: tuple[str, ...], found: Found) -> Vehicle:
    parameters = dict(vehicle.parameters)
    for name, value, deviation in zip(names, found.values.tolist(), found.deviations.tolist(), strict=True):
        parameters[name] = Parameter(name, value, parameters[name].unit, deviation, SOURCE)
    return replace(vehicle, parameters=parameters)
