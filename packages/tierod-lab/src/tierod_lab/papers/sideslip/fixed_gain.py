"""Estimation error of an observer with a fixed gain: its decay, and its steady-state covariance under noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.models.linear import LinearSystem


class Spread(NamedTuple):
    """Steady-state covariance of the corrected estimate, and of the innovation."""

    corrected: np.ndarray
    innovation: np.ndarray


def stationary_covariance(
    system: LinearSystem, gain: np.ndarray, process: Sequence[float], reading: Sequence[float]
) -> Spread:
    """Steady-state covariances of an observer with a fixed gain under process and measurement noise.

    Args:
        system: discrete
        gain: K of x = x- + K (y - C x-)
        process: process noise variance of each state per sample
        reading: noise variance of each measurement

    Source: P = (I - K C)(A P A' + Q)(I - K C)' + K R K' (Joseph), solved for P.
    """
    from scipy.linalg import solve_discrete_lyapunov

    A, C, Q, R = system.A, system.C, np.diag(process), np.diag(reading)
    left = np.eye(len(A)) - gain @ C
    corrected = solve_discrete_lyapunov(left @ A, left @ Q @ left.T + gain @ R @ gain.T)
    return Spread(corrected, C @ (A @ corrected @ A.T + Q) @ C.T + R)


def error_radius(system: LinearSystem, gain: np.ndarray) -> float:
    """Spectral radius of the error dynamics (I - K C) A; below one the error decays."""
    return float(np.abs(np.linalg.eigvals((np.eye(len(system.A)) - gain @ system.C) @ system.A)).max())
