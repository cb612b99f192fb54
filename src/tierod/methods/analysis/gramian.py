"""Gramians: how much of a state reaches the outputs, and how much the inputs reach of a state."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem

_SLOWEST = 1e-9


def observability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(A't) C'C exp(At), (n, n).

    Args:
        system: continuous
        horizon: from 0 to this time [s]; None for all time, which only a stable system has

    Raises:
        ParameterError: all time is asked of a system with an eigenvalue at zero or right of it, or a horizon that is no
            time
    """
    from scipy.linalg import solve_continuous_lyapunov

    A, Q = system.A, system.C.T @ system.C
    if horizon is not None:
        return _over(A, Q, horizon)
    values = np.linalg.eigvals(A)
    if len(values) and values.real.max() > -_SLOWEST * np.abs(values).max():
        worst = values[np.argmax(values.real)]
        raise ParameterError(
            f"the Gramian over all time does not exist: eigenvalue {worst:.4g} 1/s does not decay; give a horizon, or "
            "shift the system left (`tierod.methods.analysis.reduction`)"
        )
    return solve_continuous_lyapunov(A.T, -Q)


def controllability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(At) BB' exp(A't), (n, n); arguments as `observability_gramian`."""
    dual = replace(system, A=system.A.T, C=system.B.T, B=system.C.T, D=system.D.T)
    return observability_gramian(dual, horizon)


def gramian_condition(gramian: np.ndarray) -> float:
    """Largest over smallest eigenvalue of the Gramian, each state in the unit that makes its own entry 1.

    These units are within a factor n of the best ones (A. van der Sluis, 1969), so that the figure tells of the system
    and not of radians. Beyond 1e14 double precision knows no more than that it is large: infinite.
    """
    size = np.sqrt(np.maximum(np.diag(gramian), 0.0))
    if not (size > 0.0).all():
        return float("inf")
    values = np.linalg.eigvalsh(gramian / np.outer(size, size))
    return float(values[-1] / values[0]) if values[0] > 1e-14 * values[-1] else float("inf")


def _over(A: np.ndarray, Q: np.ndarray, horizon: float) -> np.ndarray:
    """The integral over a time, doubled from a short one on (C. F. Van Loan, 1978, for the first piece)."""
    from scipy.linalg import expm

    if not 0.0 < horizon < float("inf"):
        raise ParameterError(f"horizon is {horizon}; expected a time greater than zero [s]")
    n = len(A)
    doublings = max(0, math.ceil(math.log2(max(float(np.linalg.norm(A, 2)) * horizon, 1.0))))
    pair = np.block([[-A.T, Q], [np.zeros((n, n)), A]]) * (horizon / 2.0**doublings)
    whole = expm(pair)
    transition = whole[n:, n:]
    gramian = transition.T @ whole[:n, n:]
    for _ in range(doublings):
        gramian = gramian + transition.T @ gramian @ transition
        transition = transition @ transition
    return 0.5 * (gramian + gramian.T)
