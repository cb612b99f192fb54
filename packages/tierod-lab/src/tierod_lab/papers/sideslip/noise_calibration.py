"""Fit of the combined estimator's noises, together with the parameters of a car, to a true sideslip."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping

import numpy as np

from tierod.core.recording import Recording
from tierod.monitors.sideslip.tuning import BAND
from tierod.vehicles import Vehicle
from tierod.vehicles.vehicle import QUANTITIES, Parameter
from tierod_lab.papers.sideslip.calibration import FARTHEST, TYRES, beside_truth, judged, prior, weighted

START: dict[str, float] = {
    "yaw_rate_drift": 0.1,
    "lateral_acceleration_noise": 1.0,
    "lateral_acceleration_wander": 0.2,
    "lateral_acceleration_wander_time": 30.0,
    "lateral_speed_drift": 0.05,
    "stiffness_wander": 0.1,
    "stiffness_wander_time": 60.0,
    "bank_wander": 0.03,
    "bank_wander_time": 6.0,
}
"""Initial noises of the fit [assumed]: between those of a virtual car and those that adaptation finds on a race car."""

HELD: dict[str, float] = {
    "yaw_rate_noise": 0.004,
    "road_wheel_angle_wander": 0.001,
    "road_wheel_angle_wander_time": 3.0,
    "friction_wander": 0.0,
    "wind_wander": 0.0,
}
"""Noises that are not fitted: stiffness, bank and offset absorb the effects of friction and wind."""

SPREAD = 0.7  # Standard deviation of the natural logarithm of a noise about its initial value; a factor of two

STEP = 1e-2  # Step of the finite differences, in standard deviations

MEMORY = 4.0
"""Time after which two errors count as independent [s]; the integral of their autocorrelation on the first 55 s of the
race laps, with typical and with fitted tyres. With less, a fit of so many parameters follows single events."""

EVALUATIONS = 8  # Largest number of function evaluations of the fit

COVERED = 0.95  # Share of the truth that the band contains after the noises are scaled [-]

FARTHEST_FACTOR = 5.0
"""Largest factor by which the noises are scaled up or down; a larger one shows that the drive cannot determine them."""


def calibrated_with_noises(
    recording: Recording, vehicle: Vehicle, names: Iterable[str] = TYRES, until: float = math.inf, rate: float = 100.0
) -> Vehicle:
    """The vehicle with the parameters and noises that bring the combined estimator closest to the truth of a drive.

    The noises are then scaled by a common factor, which hardly changes an estimate, until the 95 % band contains 95 %
    of the truth. A drive of one minute is short: two minutes and more keep the band valid on later driving.

    Args:
        recording: recording with the signals of a car and its true sideslip
        vehicle: vehicle as starting point; the noises that it gives are replaced
        names: parameters to fit together with the noises; each needs a standard deviation
        until: end of the part that is fitted [s, as the recording counts]
        rate: sampling rate [Hz]

    Raises:
        InputError: the recording has no true sideslip
        ParameterError: the vehicle lacks a parameter, or its standard deviation
    """
    from scipy.optimize import least_squares

    names = tuple(names)
    start, spread = prior(vehicle, names)
    usual = np.log(np.array(list(START.values())))

    def with_moved(moved: np.ndarray) -> Vehicle:
        values = dict(zip(names, (start + spread * moved[: len(names)]).tolist(), strict=True))
        noises = np.exp(usual + SPREAD * moved[len(names) :]).tolist()
        return with_noises(vehicle, values | dict(zip(START, noises, strict=True)) | HELD)

    def residuals(moved: np.ndarray) -> np.ndarray:
        return np.concatenate([weighted(beside_truth(recording, with_moved(moved), rate), until, rate, MEMORY), moved])

    first = np.zeros(len(names) + len(START))
    found = least_squares(residuals, first, bounds=(-FARTHEST, FARTHEST), diff_step=STEP, max_nfev=EVALUATIONS)
    best = with_moved(found.x)
    seen = beside_truth(recording, best, rate)
    counted = judged(seen, until)
    needed = float(np.quantile(np.abs(seen.error[counted]) / seen.deviation[counted], COVERED)) / BAND
    return _scaled(best, min(max(needed, 1.0 / FARTHEST_FACTOR), FARTHEST_FACTOR))


def with_noises(vehicle: Vehicle, values: Mapping[str, float], source: str = "fitted to sideslip") -> Vehicle:
    """The vehicle with these parameters, added or replaced; a standard deviation that it gives is kept."""
    changed = {}
    for name, value in values.items():
        given = vehicle.parameters.get(name)
        spread = given.standard_deviation if given else None
        changed[name] = Parameter(name, float(value), QUANTITIES[name].unit, spread, source)
    return dataclasses.replace(vehicle, parameters={**vehicle.parameters, **changed})


def _scaled(vehicle: Vehicle, factor: float) -> Vehicle:
    scaled = [name for name in (*START, *HELD) if not name.endswith("_time")]
    return with_noises(vehicle, {name: factor * vehicle[name] for name in scaled})
