"""The angle over which friction builds up after a reversal (Dahl angle), from a hysteresis loop."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class PreSliding:
    """The Dahl angle seen at the reversals of a loop.

    Args:
        angle: motion after which a reversal of friction is done to 1 - 1/e [rad]
        standard_deviation: of the mean over the reversals [rad]
        reversals: how many it was seen at
    """

    angle: float
    standard_deviation: float
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

    A reversal counts where the jump that is found is 2 F within 30 % (else an end stop or tyre torsion mixes in) and
    the angle lies inside its bounds.

    Args:
        angle: steering wheel angle [rad], shape (n,)
        torque: torque without inertia and damping [N m], shape (n,)
        corners: indices of the first sample, the reversals and the last sample
        friction_torque: from the work balance [N m]
        window: motion after a reversal that the fit uses [rad]
        smallest, largest: bounds of the Dahl angle [rad]

    Returns:
        the angle, or None where no reversal counts

    Source: Dahl's law with exponent 1 at constant direction: F*(1 - 2*exp(-d/s)) after a reversal from full friction.
    """
    from scipy.signal import savgol_filter

    if len(angle) < 11:
        return None
    smooth = savgol_filter(angle, 11, 2)
    found: list[float] = []
    for begin, end in pairwise(corners[1:]):
        direction = 1.0 if angle[end] > angle[begin] else -1.0
        around = slice(max(begin - 15, 0), begin + 15)
        begin = around.start + int(np.argmin(direction * smooth[around]))
        motion = np.maximum.accumulate(direction * (smooth[begin : end + 1] - smooth[begin]))
        count = int(np.searchsorted(motion, window))
        if count < 12 or motion[count - 1] < 0.5 * window:
            continue
        fitted = _fit(motion[:count], direction * torque[begin : begin + count], smallest, largest)
        if fitted is not None and abs(fitted[1] / (2.0 * friction_torque) - 1.0) < 0.3:
            found.append(fitted[0])
    if not found:
        return None
    spread = float(np.std(found, ddof=1)) / math.sqrt(len(found)) if len(found) > 1 else 0.5 * found[0]
    return PreSliding(float(np.mean(found)), spread, len(found))


def _fit(motion: np.ndarray, torque: np.ndarray, smallest: float, largest: float) -> tuple[float, float] | None:
    """(Dahl angle, height of the jump) of the best fit, None where it lies on a bound."""
    candidates = np.geomspace(smallest, largest, 60)
    errors, jumps = [], []
    for candidate in candidates:
        columns = np.column_stack([np.ones_like(motion), motion, -np.exp(-motion / candidate)])
        solution, *_ = np.linalg.lstsq(columns, torque, rcond=None)
        errors.append(float(np.sum((columns @ solution - torque) ** 2)))
        jumps.append(float(solution[2]))
    best = int(np.argmin(errors))
    if best in (0, len(candidates) - 1):
        return None
    return float(candidates[best]), jumps[best]
