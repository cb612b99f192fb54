"""The angle over which friction builds up after a reversal (Dahl angle), from a hysteresis loop."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class PreSliding:
    """The Dahl angle from the reversals of a loop."""

    angle: float  # motion after which the reversal of friction has reached 1 - 1/e [rad]
    standard_deviation: float  # of the mean over the reversals [rad]
    reversals: int


def pre_sliding(
    angle: np.ndarray,
    torque: np.ndarray,
    corners: list[int],
    friction_torque: float,
    window: float = math.radians(30.0),
    smallest: float = math.radians(0.1),
    largest: float = math.radians(10.0),
) -> PreSliding | None:
    """Fit torque = c0 + c1*d - sign*2*F*exp(-d/s) to the motion d after each reversal.

    A reversal counts if the fitted jump is 2 F within 30 % (otherwise an end stop or tyre torsion interferes) and the
    angle is within its bounds.

    Args:
        angle: steering wheel angle [rad], shape (n,)
        torque: without inertial and viscous torque [N m], shape (n,)
        corners: indices of the first sample, the reversals and the last sample
        friction_torque: from the work balance [N m]
        window: motion after a reversal that the fit uses [rad]
        smallest, largest: bounds of the Dahl angle [rad]

    Returns:
        the angle, or None if no reversal counts

    Source: Dahl's law with exponent 1 at constant direction: F*(1 - 2*exp(-d/s)) after a reversal from full friction.
    """
    from scipy.signal import savgol_filter

    if len(angle) < 11:
        return None
    smooth = savgol_filter(angle, 11, 2)
    found: list[_Fit] = []
    for begin, end in pairwise(corners[1:]):
        direction = 1.0 if angle[end] > angle[begin] else -1.0
        around = slice(max(begin - 15, 0), begin + 15)
        begin = around.start + int(np.argmin(direction * smooth[around]))
        motion = np.maximum.accumulate(direction * (smooth[begin : end + 1] - smooth[begin]))
        count = int(np.searchsorted(motion, window))
        if count < 12 or motion[count - 1] < 0.5 * window:
            continue
        fitted = _fit(motion[:count], direction * torque[begin : begin + count], smallest, largest)
        if fitted is not None and abs(fitted.jump / (2.0 * friction_torque) - 1.0) < 0.3:
            found.append(fitted)
    if not found:
        return None
    angles = [fit.angle for fit in found]
    spread = float(np.std(angles, ddof=1)) if len(found) > 1 else 0.0
    within = float(np.sqrt(np.mean([fit.deviation**2 for fit in found])))
    return PreSliding(float(np.mean(angles)), max(spread, within) / math.sqrt(len(found)), len(found))


class _Fit(NamedTuple):
    angle: float
    deviation: float
    jump: float


def _fit(motion: np.ndarray, torque: np.ndarray, smallest: float, largest: float) -> _Fit | None:
    """The least-squares fit; None if the angle is at a bound."""
    candidates = np.geomspace(smallest, largest, 60)
    errors = [_at(motion, torque, candidate)[0] for candidate in candidates]
    best = int(np.argmin(errors))
    if best in (0, len(candidates) - 1):
        return None
    finer = np.geomspace(candidates[best - 1], candidates[best + 1], 41)
    angle = float(finer[int(np.argmin([_at(motion, torque, candidate)[0] for candidate in finer]))])
    error, jump = _at(motion, torque, angle)
    slope = -jump * np.exp(-motion / angle) * motion / angle**2
    columns = np.column_stack([_columns(motion, angle), slope])
    inverse = np.linalg.pinv(columns.T @ columns)
    return _Fit(angle, math.sqrt(error / max(len(motion) - 4, 1) * float(inverse[3, 3])), jump)


def _columns(motion: np.ndarray, angle: float) -> np.ndarray:
    return np.column_stack([np.ones_like(motion), motion, -np.exp(-motion / angle)])


def _at(motion: np.ndarray, torque: np.ndarray, angle: float) -> tuple[float, float]:
    columns = _columns(motion, angle)
    solution, *_ = np.linalg.lstsq(columns, torque, rcond=None)
    return float(np.sum((columns @ solution - torque) ** 2)), float(solution[2])
