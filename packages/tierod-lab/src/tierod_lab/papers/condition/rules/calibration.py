"""Calibration of the coefficients and thresholds of all residuals, on fault-free drives only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.monitors.condition.signals import ConditionSample
from tierod_lab.papers.condition.rules.parameters import (
    RESIDUALS,
    CarParameters,
    Coefficients,
    ResidualCalibration,
)
from tierod_lab.papers.condition.rules.residual_set import ResidualSet, residual_set, steer_of_rolling

MARGIN = 1.15  # Ratio of a threshold to the largest fault-free residual [-]

MIRRORED = (("r7", "r11"), ("r8", "r12"), ("r9", "r13"), ("r10", "r14"), ("motor_1_share", "motor_2_share"))
"""Pairs of residuals of the left and the right side; they share one threshold, since the rules compare them."""

SETTLING = 2.0  # Warm-up of the filters at the start of every drive, which is left out [s]

FEWEST = 3000  # Smallest number of fault-free samples for a fit: half a minute at 100 Hz

_LEAST = 1e-3  # Lower bound of a threshold, for residuals that hardly move, in the unit of the residual


def calibrate_residuals(
    car: CarParameters,
    fitted: Sequence[Recording],
    healthy: Sequence[Recording],
    *,
    sample_time: float = 0.01,
    printed: bool = False,
) -> ResidualCalibration:
    """Calibrate coefficients and thresholds on fault-free drives.

    Args:
        fitted: fault-free drives for the coefficients, 5 minutes or more
        healthy: fault-free drives for the thresholds, an hour or more
        sample_time: sampling interval of all recordings [s]

    Raises:
        InputError: too little fault-free driving
    """
    known = fit_coefficients(residual_set(car, None, sample_time, printed), [samples_of(each) for each in fitted])
    block = residual_set(car, known, sample_time, printed)
    largest, count = dict.fromkeys(RESIDUALS, np.inf), 0
    for each in healthy:
        result = scan(block, samples_of(each))
        settled = slice(round(SETTLING / sample_time), None)
        count += len(result["residuals.r1"][settled])
        for name in RESIDUALS:
            sizes = np.abs(result[f"residuals.{name}"][settled][result[f"there.{name}"][settled] > 0.5])
            if len(sizes):
                most = float(np.max(sizes))
                largest[name] = most if np.isinf(largest[name]) else max(most, largest[name])
    if count < FEWEST:
        raise InputError(f"{count} samples of fault-free driving are too few for thresholds; give {FEWEST} or more")
    thresholds = {name: max(MARGIN * each, _LEAST) for name, each in largest.items()}
    for pair in MIRRORED:
        thresholds |= dict.fromkeys(pair, max(thresholds[name] for name in pair))
    return ResidualCalibration(known, thresholds, count, printed)


def samples_of(recording: Recording) -> np.ndarray:
    """Samples of a recording in the columns of `ConditionSample`, (n, 14); NaN for a missing signal.

    Args:
        recording: recording with its channels on one time grid

    Raises:
        InputError: all signals are missing, or they are not on one time grid
    """
    names = [name for name in ConditionSample._fields if name in recording.channels]
    if not names:
        raise InputError("the recording has none of the signals of the condition monitor; map its channels first")
    lengths = {len(recording[name].values) for name in names}
    if len(lengths) > 1:
        raise InputError(f"the signals have {sorted(lengths)} samples; align them on one grid first")
    columns = np.full((lengths.pop(), len(ConditionSample._fields)), np.nan)
    for name in names:
        columns[:, ConditionSample._fields.index(name)] = recording[name].values
    return columns


def fit_coefficients(block: ResidualSet, drives: Sequence[np.ndarray]) -> Coefficients:
    """The coefficients of eqs (11) and (46), and the understeer, by least squares.

    Args:
        block: residuals whose filters and parameters are used; its coefficients have no effect
        drives: fault-free drives, columns of `ConditionSample`

    Raises:
        InputError: too little driving
    """
    car, rows = block.car, []
    for samples in drives:
        steer = scan(block.steering, samples[:, [3, 4, 5, 7]])
        left, right, yaw, turned = samples[:, :4].T
        use = np.isfinite(samples[:, :8]).all(axis=1) & (np.maximum(left, right) > block.moving)
        use[: round(SETTLING / block.steering.sample_time)] = False
        columns = {name: steer[name] for name in block.steering.Output._fields} | {
            "speed": 0.5 * (left + right),
            "turning": 0.5 * (left + right) * yaw,
            "steer": car.steering_ratio * turned,
            "slip": car.steering_ratio * turned - steer_of_rolling(yaw, left, right, car),
            "along": samples[:, 6],
            "across": samples[:, 7],
            "driven": (samples[:, 10] + samples[:, 11]) / car.wheel_radius,
        }
        rows.append({name: each[use] for name, each in columns.items()})
    of = {name: np.concatenate([each[name] for each in rows]) for name in rows[0]}
    across, known = of["lateral_acceleration"], np.isfinite(of["driven"])
    torque = _fitted(of["torque"], of["angle"], of["rate"], of["acceleration"], of["direction"], across)
    per_mass, per_torque, rubbing, offset = _fitted(of["force"], car.mass * across, of["torque"], of["direction"])
    understeer, angle_offset = _fitted(of["slip"], of["turning"])
    drive = {name: each[known] for name, each in of.items()}
    driven = [0.0] * 4  # recordings may lack the targets of the drives
    if known.sum() >= FEWEST:
        inertia, drag, sides, resistance = _fitted(
            drive["driven"], drive["along"], drive["speed"] ** 2, drive["across"] * drive["steer"]
        )
        driven = [inertia, resistance, drag, sides]
    # Eq (46) subtracts friction from the torque before the factor `per_torque`; here it was fitted after it.
    force = per_mass, per_torque, -rubbing / per_torque if per_torque else 0.0, offset
    values = [*torque, *force, understeer, angle_offset / car.steering_ratio, *driven]
    return Coefficients(*values)


def _fitted(wanted: np.ndarray, *regressors: np.ndarray) -> list[float]:
    """Factors of the regressors, and a constant."""
    if len(wanted) < FEWEST:
        raise InputError(
            f"{len(wanted)} samples of fault-free driving are too few to fit the residuals' models on; "
            f"give {FEWEST} or more while the vehicle moves"
        )
    columns = np.column_stack([*regressors, np.ones(len(wanted))])
    return [float(each) for each in np.linalg.lstsq(columns, wanted, rcond=1e-9)[0]]
