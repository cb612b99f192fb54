"""Fit of the combined estimator's parameters to a true sideslip on the first part of a drive."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import Result, scan, trace
from tierod.core.recording import Recording
from tierod.monitors.sideslip.definition import SideslipMonitor
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.monitors.sideslip.evidence import TRUTHS
from tierod.monitors.sideslip.tuning import BAND, CombinedTuning
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of an estimate against the truth."""

    mean_absolute: float  # mean_absolute, rms: mean absolute and root mean square error [rad]
    rms: float
    coverage: float  # share of the samples whose truth lies within the 95 % band

    def __str__(self) -> str:
        return f"{math.degrees(self.mean_absolute):.3f} / {math.degrees(self.rms):.3f}"


@dataclass(frozen=True)
class BesideTruth:
    """An estimate of the sideslip with the truth, (n,) each."""

    time: np.ndarray  # time of each sample [s]
    estimate: np.ndarray  # estimate, deviation: sideslip angle and its standard deviation [rad]
    deviation: np.ndarray
    truth: np.ndarray  # true sideslip angle [rad]; NaN where there is none
    result: Result | None = None  # all outputs of the estimator; None for an estimate from elsewhere

    @cached_property
    def error(self) -> np.ndarray:
        """Estimate less truth [rad]."""
        error: np.ndarray = self.estimate - self.truth
        return error

    def figures(self, start: float = -math.inf, stop: float = math.inf) -> ErrorFigures:
        """The errors between two times."""
        judged = (self.time >= start) & (self.time < stop) & np.isfinite(self.error)
        if not judged.any():
            raise InputError(f"there is no true sideslip from {start:g} to {stop:g} s; give times within the drive")
        error = self.error[judged]
        coverage = float(np.mean(np.abs(error) <= BAND * self.deviation[judged]))
        return ErrorFigures(float(np.mean(np.abs(error))), float(np.sqrt(np.mean(error * error))), coverage)


def truth_of(recording: Recording) -> str:
    """Name of the channel with the true sideslip."""
    for name in TRUTHS:
        if name in recording:
            return name
    raise InputError(f"the recording has none of {' and '.join(TRUTHS)}; name the true sideslip in the channel map")


def beside_truth(
    recording: Recording, vehicle: Vehicle, rate: float = 100.0, tuning: CombinedTuning | None = None
) -> BesideTruth:
    """Run the combined estimator of a vehicle over a recording.

    Args:
        recording: recording with the signals of a car and its true sideslip
        rate: sampling rate [Hz]
        tuning: tuning of the estimator; the vehicle's own where None
    """
    truth = truth_of(recording)
    block = SideslipMonitor.of_vehicle(CombinedSideslip.of_vehicle(vehicle, 1.0 / rate, tuning), vehicle)
    signals = trace(block).sample
    aligned = recording.align((*signals, truth), rate, maximum_age=0.1)
    result = scan(block, aligned.values[:, :-1])
    angle, deviation = result["statement.magnitude"], result["statement.deviation"]
    return BesideTruth(aligned.time, angle, deviation, aligned.values[:, -1], result)


TYRES = ("front_cornering_stiffness", "rear_cornering_stiffness", "tyre_friction", "rear_friction_ratio")
"""Parameters to fit again after a change of tyres."""

EXPECTED = math.radians(0.2)  # Error of a good fit [rad]; that of the best estimators on real cars

MEMORY = 0.4  # Time after which two errors count as independent [s]; that of a steering movement

SETTLING = 1.0  # Start of the drive that is left out of the fit [s]

FARTHEST = 3.0  # Largest change of a parameter from its value in the vehicle file, in standard deviations

EVERY = 10  # Decimation of the samples in the fit: errors change slowly


def calibrated(
    recording: Recording, vehicle: Vehicle, names: Iterable[str] = TYRES, until: float = math.inf, rate: float = 100.0
) -> Vehicle:
    """The vehicle with the parameters that bring the combined estimator closest to the truth of a drive.

    The values and standard deviations of the vehicle file are the prior, so that parameters that are not identifiable
    from the drive keep their values. Fit on one part of the drives and judge on another.

    Args:
        recording: recording with the signals of a car and its true sideslip
        names: parameters to fit; each needs a standard deviation
        until: end of the part that is fitted [s, as the recording counts]
        rate: sampling rate [Hz]
    """
    from scipy.optimize import least_squares

    names = tuple(names)
    start = np.array([vehicle[name] for name in names])
    spreads = [vehicle.parameters[name].standard_deviation for name in names]
    if unknown := [name for name, each in zip(names, spreads, strict=True) if not each]:
        raise ParameterError(
            f"the vehicle '{vehicle.name}' gives no standard deviation of {', '.join(unknown)}, which limits how far a "
            "fit may change it; add standard_deviation to its table"
        )
    spread = np.array(spreads, float)

    def with_moved(moved: np.ndarray) -> Vehicle:
        return with_parameters(vehicle, dict(zip(names, (start + spread * moved).tolist(), strict=True)))

    def residuals(moved: np.ndarray) -> np.ndarray:
        """Errors weighted to one term per independent error, and the deviations from the prior."""
        seen = beside_truth(recording, with_moved(moved), rate)
        counted = (seen.time > seen.time[0] + SETTLING) & (seen.time < until) & np.isfinite(seen.error)
        # The clip bounds the cost of a filter that is lost.
        error = np.clip(seen.error[counted][::EVERY], -1.0, 1.0)
        return np.concatenate([math.sqrt(EVERY / rate / MEMORY) / EXPECTED * error, moved])

    bounds = (-FARTHEST, FARTHEST)
    found = least_squares(residuals, np.zeros(len(names)), bounds=bounds, diff_step=1e-3, x_scale=1.0, max_nfev=20)
    return with_moved(found.x)


def with_parameters(vehicle: Vehicle, values: Mapping[str, float], source: str = "fitted to sideslip") -> Vehicle:
    """The vehicle with new values of some of its parameters."""
    for name in values:
        vehicle[name]
    changed = {
        name: dataclasses.replace(vehicle.parameters[name], value=value, source=source)
        for name, value in values.items()
    }
    return dataclasses.replace(vehicle, parameters={**vehicle.parameters, **changed})
