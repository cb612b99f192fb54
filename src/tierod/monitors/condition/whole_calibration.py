"""All that healthy driving tells of a vehicle: its parameters from the first minutes, its limits from the rest."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tierod.errors import InputError
from tierod.identification.column_result import Found
from tierod.monitors.condition.calibration import Calibration, calibrate
from tierod.monitors.condition.limits import NAME, DesignedLimits, design_limits, table_of
from tierod.monitors.condition.residuals.calibration import ResidualCalibration, calibrate_residuals
from tierod.monitors.condition.residuals.in_vehicle_file import name_of
from tierod.monitors.condition.residuals.in_vehicle_file import table_of as residual_table
from tierod.monitors.condition.residuals.parameters import ResidualParameters
from tierod.monitors.condition.signals import SENSORS
from tierod.recording import Recording
from tierod.vehicles import Vehicle

FOR_PARAMETERS = 300.0
"""Of driving at the beginning, that tells the parameters [s]."""
MOVING = 1.0
"""Speed from which on the vehicle moves [m/s]."""
LARGEST_SQUARE = 3.0
"""Mean squared innovation over its variance from which on a reading does not fit the vehicle at all."""
INTERVAL = 1.96


@dataclass(frozen=True)
class ConditionCalibration:
    """Parameters and limits of a vehicle.

    Args:
        calibration: of the parameters
        designed: limits
        residuals: coefficients and thresholds of the paper's residuals, corrected and as printed
        before: the vehicle as it was
        seconds: of driving that the parameters come from
    """

    calibration: Calibration
    designed: DesignedLimits
    residuals: tuple[ResidualCalibration, ResidualCalibration]
    before: Vehicle
    seconds: float

    @property
    def found(self) -> tuple[Found, ...]:
        """Parameters, in the order in which they were looked for."""
        rows = zip(
            self.calibration.names,
            self.calibration.values.tolist(),
            self.calibration.deviations.tolist(),
            strict=True,
        )
        return tuple(
            Found(
                name,
                self.before[name],
                self.before.parameters[name].standard_deviation,
                value,
                deviation,
                value - INTERVAL * deviation,
                value + INTERVAL * deviation,
                "likelihood",
            )
            for name, value, deviation in rows
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was noticed."""
        designed = self.designed
        rest, between = designed.hours, f"{designed.hours_between_alarms:,.0f}".replace(",", " ")
        told = [
            f"The parameters come from the first {self.seconds:.0f} s of driving, the limits from {rest:.2f} h after "
            f"them; in {designed.alarms_before} of all times of ten seconds one half of that driving went beyond the "
            "largest ratio of the other.",
            f"With limits {designed.factor:.2f} times the largest ratios one false alarm in {between} h is to be "
            f"expected, carried on from their tail; {rest:.1f} h without one show fewer than {3.0 / rest:.1f} per hour "
            "at 95 %.",
        ]
        if not self.calibration.converged:
            told.append(
                "The search for the parameters did not come to its end; give more driving with bends and braking."
            )
        return tuple(told)

    @property
    def doubt(self) -> str:
        """Why the values may not be used; empty where they may."""
        worst = {
            name: value
            for name, value in zip(SENSORS, self.calibration.squares, strict=False)
            if value > LARGEST_SQUARE
        }
        if not worst:
            return ""
        listed = ", ".join(f"{name} ({value:.1f})" for name, value in worst.items())
        return (
            f"the readings of {listed} do not fit the vehicle (mean squared innovation over its variance, expected "
            "about 1): is a sensor faulty, a sign or a ratio wrong, or the vehicle of another kind?"
        )

    @property
    def thresholds(self) -> Mapping[str, Mapping[str, float | str | Mapping[str, float]]]:
        """Limits as the vehicle file holds them, by what they are of."""
        source = f"designed on {self.designed.hours:.2f} h of healthy driving of {self.before.name}"
        rules = {name_of(each.printed): residual_table(each, source) for each in self.residuals}
        return {NAME: table_of(self.designed, source), **rules}


def calibrate_condition(
    recordings: Mapping[str, Recording],
    vehicle: Vehicle,
    hours_between_alarms: float = 1000.0,
    progress: Callable[[float], None] = lambda share: None,
) -> ConditionCalibration:
    """Parameters and limits of a vehicle from its healthy drives, in the order in which they are given.

    Args:
        recordings: of healthy driving by name, five minutes and, beyond them, an hour or more
        vehicle: where to start from
        hours_between_alarms: wanted mean time between false alarms [h]
        progress: called with the share that is done

    Raises:
        InputError: too little driving, or recordings without wheel speeds
    """
    for name, recording in recordings.items():
        missing = [each for each in SENSORS[:2] if each not in recording]
        if missing:
            raise InputError(f"{name} has no {missing[0]}; 'tierod inspect' shows what it has")
    first, rest, seconds = _parted(list(recordings.values()))
    calibration = calibrate(first, vehicle, lambda share: progress(0.5 * share))
    designed = design_limits(rest, calibration.vehicle, hours_between_alarms, lambda share: progress(0.5 + 0.4 * share))
    car = vehicle.parameters_for(ResidualParameters)
    corrected, as_printed = (calibrate_residuals(car, first, rest, printed=each) for each in (False, True))
    return ConditionCalibration(calibration, designed, (corrected, as_printed), vehicle, seconds)


def _parted(recordings: list[Recording]) -> tuple[list[Recording], list[Recording], float]:
    """The first `FOR_PARAMETERS` of driving, all after them, and how long the first part drives [s]."""
    first, rest, driven = [], [], 0.0
    for recording in recordings:
        wheel = recording[SENSORS[0]]
        moving = np.cumsum(np.diff(wheel.time, prepend=wheel.time[0]) * (np.nan_to_num(wheel.values) > MOVING))
        left = FOR_PARAMETERS - driven
        if left <= 0.0:
            rest.append(recording)
        elif moving[-1] <= left:
            first.append(recording)
            driven += float(moving[-1])
        else:
            cut = float(wheel.time[np.searchsorted(moving, left)])
            first.append(recording.slice(stop=cut))
            rest.append(recording.slice(cut))
            driven = FOR_PARAMETERS
    return first, rest, driven
