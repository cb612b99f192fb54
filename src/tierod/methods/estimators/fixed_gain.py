"""Errors of an observer with a fixed gain: how fast they decay, and what noise makes of them in the long run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.models.linear import LinearSystem


class Spread(NamedTuple):
    """Covariance of the estimate after a sample, and of the innovation."""

    corrected: np.ndarray
    innovation: np.ndarray


def stationary_covariance(
    system: LinearSystem, gain: np.ndarray, process: Sequence[float], reading: Sequence[float]
) -> Spread:
    """Stationary spread of an observer with a fixed gain, as noise makes it.

    Args:
        system: discrete
        gain: K of x = x- + K (y - C x-)
        process: variance that each state gains per sample
        reading: variance of each measurement

    Source: P = (I - K C)(A P A' + Q)(I - K C)' + K R K' (Joseph), solved for P.
    """
    from scipy.linalg import solve_discrete_lyapunov

    A, C, Q, R = system.A, system.C, np.diag(process), np.diag(reading)
    left = np.eye(len(A)) - gain @ C
    corrected = solve_discrete_lyapunov(left @ A, left @ Q @ left.T + gain @ R @ gain.T)
    return Spread(corrected, C @ (A @ corrected @ A.T + Q) @ C.T + R)


def error_radius(system: LinearSystem, gain: np.ndarray) -> float:
    """Largest size of the eigenvalues of the error, (I - K C) A; below one it decays."""
    return float(np.abs(np.linalg.eigvals((np.eye(len(system.A)) - gain @ system.C) @ system.A)).max())
