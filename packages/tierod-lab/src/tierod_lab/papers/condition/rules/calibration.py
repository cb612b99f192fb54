"""Calibration of the coefficients and thresholds of all residuals, on fault-free drives only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.detectors.rule_design import threshold_from_records
from tierod.methods.detectors.stopping_rules import HoldRule
from tierod_lab.papers.condition.rules.actuator_set import actuator_set
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.fit import FEWEST, SETTLING, fit_coefficients, samples_of
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients, ResidualParameters
from tierod_lab.papers.condition.rules.readings import GROWTHS, Excitation, ResidualThreshold
from tierod_lab.papers.condition.rules.residual_set import residual_set

MARGIN = 1.15
"""Ratio of a threshold to the largest fault-free residual [-], where it is not designed for a false-alarm rate."""

MIRRORED = (("r7", "r11"), ("r8", "r12"), ("r9", "r13"), ("r10", "r14"), ("motor_1_share", "motor_2_share"))
"""Pairs of residuals of the left and the right side; they share one threshold, since the rules compare them."""

_LEAST = 1e-3  # Lower bound of a threshold, for residuals that hardly move, in the unit of the residual


@dataclass(frozen=True)
class ResidualCalibration:
    """Calibration of the residuals of a vehicle."""

    coefficients: Coefficients  # coefficients of the models
    thresholds: Mapping[str, ResidualThreshold]  # threshold by residual
    deviations: Mapping[str, float]  # fault-free standard deviation by residual, in its unit
    samples: int  # number of fault-free samples behind the thresholds
    printed: bool = False  # whether the equations keep their misprints
    adaptive: bool = False  # whether thresholds grow with excitation, where that lowers them on average
    # mean time between false alarms of each residual for which the thresholds are designed; None where they are the
    # largest fault-free residual with a margin
    hours_between_alarms: Annotated[float, "h"] | None = None


def calibrate_residuals(
    car: ResidualParameters,
    fitted: Sequence[Recording],
    healthy: Sequence[Recording],
    *,
    sample_time: float = 0.01,
    printed: bool = False,
    adaptive: bool = False,
    hours_between_alarms: float | None = None,
) -> ResidualCalibration:
    """Calibrates coefficients and thresholds on fault-free drives.

    Args:
        fitted: fault-free drives for the coefficients, 5 minutes or more
        healthy: fault-free drives for the thresholds, an hour or more
        sample_time: sampling interval of all recordings [s]
        adaptive: whether a threshold may grow with speed, yaw acceleration, lateral acceleration and steering rate; it
            does where that lowers it on average
        hours_between_alarms: mean time between false alarms of each residual [h]; None takes 1.15 times the largest
            fault-free residual

    Raises:
        InputError: too little fault-free driving
        ParameterError: `hours_between_alarms` is not positive
    """
    if hours_between_alarms is not None and not hours_between_alarms > 0.0:
        raise ParameterError(f"hours_between_alarms is {hours_between_alarms}; expected more than zero")
    block = residual_set(car, None, sample_time, printed)
    known = fit_coefficients(block, [samples_of(each) for each in fitted])
    whole = AllResiduals(residual_set(car, known, sample_time, printed), actuator_set(car, known, sample_time))
    drives = [_Healthy.of(whole, samples_of(each), sample_time) for each in healthy]
    count = sum(len(each.excitation) for each in drives)
    if count < FEWEST:
        raise InputError(f"{count} samples of fault-free driving are too few for thresholds; give {FEWEST} or more")
    alarm_samples = None if hours_between_alarms is None else hours_between_alarms * 3600.0 / sample_time
    thresholds, deviations = {}, {}
    for name in RESIDUALS:
        thresholds[name], deviations[name] = _threshold(drives, name, adaptive, alarm_samples)
    for left, right in MIRRORED:
        thresholds |= _alike(left, thresholds[left], right, thresholds[right])
    return ResidualCalibration(known, thresholds, deviations, count, printed, adaptive, hours_between_alarms)


@dataclass(frozen=True)
class _Healthy:
    """Residuals of a fault-free drive, NaN where missing, and excitations, (n, 5), whose first column is one."""

    residuals: dict[str, np.ndarray]
    excitation: np.ndarray

    @classmethod
    def of(cls, block: AllResiduals, samples: np.ndarray, sample_time: float) -> _Healthy:
        result = scan(block, samples)
        settled = slice(round(SETTLING / sample_time), None)
        residuals = {
            name: np.where(result[f"there.{name}"] > 0.5, result[f"residuals.{name}"], np.nan)[settled]
            for name in RESIDUALS
        }
        lively = [np.abs(result[f"excitation.{name}"][settled]) for name in Excitation._fields]
        return cls(residuals, np.stack([np.ones_like(lively[0]), *lively], axis=1))


def _threshold(
    drives: Sequence[_Healthy], name: str, adaptive: bool, alarm_samples: float | None
) -> tuple[ResidualThreshold, float]:
    values = np.concatenate([each.residuals[name] for each in drives])
    there = np.isfinite(values)
    if there.sum() < FEWEST:
        return ResidualThreshold(np.inf), np.nan
    deviation = float(np.std(values[there]))
    plain = not adaptive and alarm_samples is None
    # The thresholds of the paper are symmetric about zero.
    centre = 0.0 if plain else float(np.median(values[there]))
    lively = np.concatenate([each.excitation for each in drives])[there]
    shapes = [_FIXED, *([_spread(lively, np.abs(values[there] - centre))] if adaptive else [])]
    found = []
    for shape in shapes:
        relative = [(each.residuals[name] - centre) / (each.excitation @ shape) for each in drives]
        found.append(_scale(relative, alarm_samples) * shape)
    lowest = min(found, key=lambda each: float(np.mean(lively @ each)))
    growths = dict(zip(GROWTHS, (float(each) for each in lowest[1:]), strict=True))
    return ResidualThreshold(max(float(lowest[0]), _LEAST), **growths, centre=centre), deviation


_FIXED = np.array([1.0, 0.0, 0.0, 0.0, 0.0])


def _scale(relative: Sequence[np.ndarray], alarm_samples: float | None) -> float:
    if alarm_samples is None:
        return MARGIN * max(float(np.nanmax(np.abs(each))) for each in relative if np.isfinite(each).any())
    design = threshold_from_records(HoldRule(sides="both", hold=1), relative, alarm_samples)
    return design.threshold * design.deviation


def _alike(left: str, first: ResidualThreshold, right: str, second: ResidualThreshold) -> dict[str, ResidualThreshold]:
    names = ("base", *GROWTHS)
    parts = {name: max(getattr(first, name), getattr(second, name)) for name in names}
    return {left: replace(first, **parts), right: replace(second, **parts)}


def _spread(excitation: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Mean magnitude of a residual as a non-negative linear combination of the excitations, (5,)."""
    from scipy.optimize import nnls

    thinned = slice(None, None, 5)
    found, _ = nnls(excitation[thinned], size[thinned])
    # Residuals are divided by this shape: without a base it would vanish at rest.
    found[0] = max(found[0], 0.2 * float(np.mean(size)))
    return np.asarray(found)
