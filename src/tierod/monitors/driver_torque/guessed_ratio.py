"""The motor ratio of a car whose vehicle file only guesses it: the angles show it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.monitors.driver_torque.column_regression import GeometryOverDrive
from tierod.monitors.driver_torque.decisions import RATIO_SPREAD, FitRules
from tierod.vehicles import Vehicle
from tierod.vehicles.uncertain import is_guess

NAME = "motor_ratio"


def spread_of(vehicle: Vehicle) -> float:
    """Standard deviation of the motor ratio over its value; 0 where the file gives none, as `RATIO_SPREAD` is added.

    Args:
        vehicle: whose column it is
    """
    known = vehicle.parameters[NAME]
    return (known.standard_deviation or 0.0) / known.value


def is_guessed(vehicle: Vehicle) -> bool:
    """Whether the ratio is known to less than a column with a design value: one wrong by more feigns torques.

    Args:
        vehicle: whose column it is
    """
    return is_guess(vehicle.parameters[NAME], RATIO_SPREAD)


def seen(
    vehicle: Vehicle, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray, rate: float
) -> float | None:
    """The ratio by which the angles go; None where they do not show it to `RATIO_SPREAD`.

    Args:
        vehicle: whose column it is
        wheel_angle, motor_angle: of the first piece [rad], (n,)
        driver_torque: in the bar [N*m], (n,)
        rate: of the samples [Hz]
    """
    geometry = GeometryOverDrive(rate)
    geometry.add(wheel_angle, motor_angle, driver_torque)
    found = geometry.found()
    return None if found is None or found.ratio_uncertainty > RATIO_SPREAD else found.ratio


def is_of_file(vehicle: Vehicle, ratio: float, rules: FitRules) -> bool:
    """Whether a ratio that was seen is that of the vehicle file, by its standard deviation.

    Args:
        vehicle: whose column it is
        ratio: that the angles show []
        rules: whether vehicle file and recording fit
    """
    return not rules.apart(ratio / vehicle[NAME] - 1.0, spread_of(vehicle))


def with_ratio(vehicle: Vehicle, ratio: float) -> Vehicle:
    """The vehicle with a ratio that was seen.

    Args:
        vehicle: whose file guesses it
        ratio: that the angles show []
    """
    known = replace(vehicle.parameters[NAME], value=ratio, standard_deviation=0.0)
    return replace(vehicle, parameters={**vehicle.parameters, NAME: known})


def remark(vehicle: Vehicle, ratio: float | None) -> str:
    """A notice that the ratio was guessed, and what was done.

    Args:
        vehicle: as its file gives it
        ratio: that the angles show over the drive []; None where they do not
    """
    known = vehicle.parameters[NAME]
    file = f"{NAME} is {known.value:.4g} ± {known.standard_deviation or 0.0:.2g} in the vehicle file"
    if ratio is None:
        return f"motor_angle_mechanical is not used: {file}, and the angles of the beginning do not show it"
    return f"{file}, and the angles go by {ratio:.4g}, which is used: enter {NAME} = {ratio:.4g}"
