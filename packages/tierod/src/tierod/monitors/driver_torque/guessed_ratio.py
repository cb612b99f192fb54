"""Motor ratio of a car whose vehicle file only guesses it, from the angles of the recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tierod.monitors.driver_torque.column_regression import GeometryOverDrive
from tierod.monitors.driver_torque.decisions import RATIO_SPREAD, FitRules
from tierod.vehicles import Vehicle
from tierod.vehicles.uncertain import is_guess

MOTOR_RATIO = "motor_ratio"


def ratio_spread(vehicle: Vehicle) -> float:
    """Relative standard deviation of the motor ratio; 0 where the file gives none, since `RATIO_SPREAD` is added.

    Args:
        vehicle: vehicle of the column
    """
    known = vehicle.parameters[MOTOR_RATIO]
    return (known.standard_deviation or 0.0) / known.value


def ratio_is_guessed(vehicle: Vehicle) -> bool:
    """Whether the ratio is less certain than a design value; one wrong by more imitates torques.

    Args:
        vehicle: vehicle of the column
    """
    return is_guess(vehicle.parameters[MOTOR_RATIO], RATIO_SPREAD)


def ratio_of_angles(
    vehicle: Vehicle, wheel_angle: np.ndarray, motor_angle: np.ndarray, driver_torque: np.ndarray, rate: float
) -> float | None:
    """The ratio of the angles; None where they do not give it within `RATIO_SPREAD`.

    Args:
        vehicle: vehicle of the column
        wheel_angle, motor_angle: angles of the first piece [rad], (n,)
        driver_torque: torque in the bar [N*m], (n,)
        rate: sampling rate [Hz]
    """
    geometry = GeometryOverDrive(rate)
    geometry.add(wheel_angle, motor_angle, driver_torque)
    found = geometry.found()
    return None if found is None or found.ratio_uncertainty > RATIO_SPREAD else found.ratio


def ratio_fits(vehicle: Vehicle, ratio: float, rules: FitRules) -> bool:
    """Whether an identified ratio agrees with that of the vehicle file within its standard deviation.

    Args:
        vehicle: vehicle of the column
        ratio: ratio of the angles [-]
        rules: rules on the agreement of vehicle file and recording
    """
    return not rules.apart(ratio / vehicle[MOTOR_RATIO] - 1.0, ratio_spread(vehicle))


def with_ratio(vehicle: Vehicle, ratio: float) -> Vehicle:
    """The vehicle with an identified ratio.

    Args:
        vehicle: vehicle whose file guesses the ratio
        ratio: ratio of the angles [-]
    """
    # Zero, so that the identified ratio no longer counts as a guess.
    known = replace(vehicle.parameters[MOTOR_RATIO], value=ratio, standard_deviation=0.0)
    return replace(vehicle, parameters={**vehicle.parameters, MOTOR_RATIO: known})


def ratio_remark(vehicle: Vehicle, ratio: float | None) -> str:
    """Notice that the ratio was guessed, and what was used instead.

    Args:
        vehicle: vehicle as in its file
        ratio: ratio of the angles over the drive [-]; None where they do not give it
    """
    known = vehicle.parameters[MOTOR_RATIO]
    file = f"{MOTOR_RATIO} is {known.value:.4g} ± {known.standard_deviation or 0.0:.2g} in the vehicle file"
    if ratio is None:
        return f"motor_angle_mechanical is not used: {file}, and the angles at the beginning do not determine it"
    return f"{file}, but the ratio of the angles is {ratio:.4g}, which is used: enter {MOTOR_RATIO} = {ratio:.4g}"
