"""Stationary Kalman gain from the Riccati equation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import TOLERANCE, LinearSystem, describe, modes

Noises: TypeAlias = Sequence[float | None] | Sequence[Sequence[float]] | np.ndarray
"""Variances (None for no noise), or a full covariance matrix."""


@dataclass(frozen=True, eq=False)
class StationaryGain:
    """Steady state of a Kalman filter for a time-invariant system."""

    filter: np.ndarray  # gain K of x = x- + K (y - C x-), (n, outputs), as used by the estimators of tierod
    # gain A K of x-(k+1) = A x-(k) + B u + A K (y - C x-), (n, outputs), as returned by dlqe of python-control
    predictor: np.ndarray
    predicted_covariance: np.ndarray  # of x-, before the measurement, (n, n)
    covariance: np.ndarray  # of x, after the measurement, (n, n)
    innovation_covariance: np.ndarray  # C P- C' + R, (outputs, outputs)


def stationary_gain(
    system: LinearSystem, process_noise: Noises, measurement_noise: Noises, input_noise: Noises | None = None
) -> StationaryGain:
    """The stationary Kalman gain of a discrete system, by SciPy's Riccati solver.

    Args:
        process_noise: variance of each state per sample, (n,), None for none; or the full Q, (n, n)
        measurement_noise: variance of each output, (outputs,); or the full R
        input_noise: variance of each input, (inputs,), None for none; adds B diag(w) B'

    Raises:
        ParameterError: noise of the wrong shape, or no stationary gain: a direction that does not decay is not
            observable (it is named), or has no process noise
    """
    from scipy.linalg import solve_discrete_are

    A, C = system.A, system.C
    Q, R = _matrix(process_noise, len(A), "process_noise"), _matrix(measurement_noise, len(C), "measurement_noise")
    if input_noise is not None:
        Q = Q + system.B @ _matrix(input_noise, system.B.shape[1], "input_noise") @ system.B.T
    _require_detectable(system)
    try:
        predicted = solve_discrete_are(A.T, C.T, Q, R)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise _no_limit(system, str(error)) from None
    spread = C @ predicted @ C.T + R
    gain = np.linalg.solve(spread, C @ predicted).T
    left = np.eye(len(A)) - gain @ C
    if np.abs(np.linalg.eigvals(left @ A)).max() >= 1.0 - 1e-12:
        raise _no_limit(system, "the error of the filter does not decay")
    # Joseph's form keeps the covariance positive in spite of rounding.
    after = left @ predicted @ left.T + gain @ R @ gain.T
    return StationaryGain(gain, A @ gain, predicted, 0.5 * (after + after.T), 0.5 * (spread + spread.T))


def _matrix(noise: Noises, n: int, what: str) -> np.ndarray:
    values = [0.0 if entry is None else entry for entry in noise]
    matrix = np.asarray(values, float)
    matrix = np.diag(matrix) if matrix.ndim == 1 else matrix
    if matrix.shape != (n, n) or not np.isfinite(matrix).all() or np.linalg.eigvalsh(matrix).min() < -1e-12:
        raise ParameterError(
            f"{what} gives a matrix of shape {matrix.shape}; expected {n} variances, or a ({n}, {n}) covariance"
        )
    return matrix


def _require_detectable(system: LinearSystem) -> None:
    for mode in modes(system):
        if mode.margin < TOLERANCE and abs(mode.eigenvalue) >= 1.0 - 1e-9:
            raise ParameterError(
                f"there is no stationary gain: through {', '.join(system.outputs)} the direction "
                f"{describe(mode.direction, system.states)} (eigenvalue {mode.number}) is not observable and does not "
                "decay; "
                "measure it, or take it out of the state"
            )


def _no_limit(system: LinearSystem, reason: str) -> ParameterError:
    lasting = [name for name, row in zip(system.states, system.A, strict=True) if np.abs(row).sum() >= 1.0]
    return ParameterError(
        f"there is no stationary gain ({reason}); give every state that does not decay by itself "
        f"(among {', '.join(lasting) or ', '.join(system.states)}) process noise greater than zero"
    )
