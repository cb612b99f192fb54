"""The combined estimator over a recording that contains the true sideslip: estimate, band and truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import Result, scan, trace
from tierod.core.recording import Recording
from tierod.monitors.sideslip.combined import CombinedSideslip
from tierod.monitors.sideslip.combined_tuning import CombinedTuning
from tierod.monitors.sideslip.drive import TRUTHS
from tierod.monitors.sideslip.grip_limit import BAND
from tierod.monitors.sideslip.monitor import SideslipMonitor
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of an estimate against the truth.

    Args:
        mean_absolute, rms: mean absolute and root mean square error [rad]
        coverage: share of the samples whose truth lies within the 95 % band
    """

    mean_absolute: float
    rms: float
    coverage: float

    def __str__(self) -> str:
        return f"{math.degrees(self.mean_absolute):.3f} / {math.degrees(self.rms):.3f}"


@dataclass(frozen=True)
class BesideTruth:
    """An estimate of the sideslip with the truth, (n,) each.

    Args:
        time: time of each sample [s]
        estimate, deviation: sideslip angle and its standard deviation [rad]
        truth: true sideslip angle [rad]; NaN where there is none
        result: all outputs of the estimator; None for an estimate from elsewhere
    """

    time: np.ndarray
    estimate: np.ndarray
    deviation: np.ndarray
    truth: np.ndarray
    result: Result | None = None

    @cached_property
    def error(self) -> np.ndarray:
        """Estimate less truth [rad]."""
        error: np.ndarray = self.estimate - self.truth
        return error

    def figures(self, start: float = -math.inf, stop: float = math.inf) -> ErrorFigures:
        """The errors between two times.

        Raises:
            InputError: there is no truth between them
        """
        judged = (self.time >= start) & (self.time < stop) & np.isfinite(self.error)
        if not judged.any():
            raise InputError(f"there is no true sideslip from {start:g} to {stop:g} s; give times within the drive")
        error = self.error[judged]
        coverage = float(np.mean(np.abs(error) <= BAND * self.deviation[judged]))
        return ErrorFigures(float(np.mean(np.abs(error))), float(np.sqrt(np.mean(error * error))), coverage)


def truth_of(recording: Recording) -> str:
    """Name of the channel with the true sideslip.

    Raises:
        InputError: the recording has none
    """
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
        vehicle: vehicle that gives the estimator's parameters
        rate: sampling rate [Hz]
        tuning: tuning of the estimator; the vehicle's own where None

    Raises:
        InputError: the recording has no true sideslip
        ParameterError: the vehicle lacks a parameter
    """
    truth = truth_of(recording)
    block = SideslipMonitor.of_vehicle(CombinedSideslip.of_vehicle(vehicle, 1.0 / rate, tuning), vehicle)
    signals = trace(block).sample
    aligned = recording.align((*signals, truth), rate, maximum_age=0.1)
    result = scan(block, aligned.values[:, :-1])
    angle, deviation = result["statement.magnitude"], result["statement.deviation"]
    return BesideTruth(aligned.time, angle, deviation, aligned.values[:, -1], result)
