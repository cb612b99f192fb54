"""Gramians of a linear system, and balanced coordinates, in which every state is as controllable as observable."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, balance

_SLOWEST = 1e-9


def observability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(A't) C'C exp(At), (n, n).

    Args:
        system: continuous
        horizon: upper limit of the integral [s]; None for infinity, where it exists for stable systems only

    Raises:
        ParameterError: no horizon for a system with an eigenvalue that does not decay, or a horizon that is not
            positive and finite
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
            "shift the system left (`tierod_lab.papers.column.model_reduction`)"
        )
    return np.asarray(solve_continuous_lyapunov(A.T, -Q))


def controllability_gramian(system: LinearSystem, horizon: float | None = None) -> np.ndarray:
    """Integral of exp(At) BB' exp(A't), (n, n); arguments as `observability_gramian`."""
    dual = replace(system, A=system.A.T, C=system.B.T, B=system.C.T, D=system.D.T)
    return observability_gramian(dual, horizon)


def gramian_condition(gramian: np.ndarray) -> float:
    """Condition number of the Gramian, with each state in the unit that makes its diagonal entry 1.

    These units are within a factor n of the best ones (A. van der Sluis, 1969), so that the result depends on the
    system and not on its units. Beyond 1e14, the limit of double precision, the result is infinite.
    """
    size = np.sqrt(np.maximum(np.diag(gramian), 0.0))
    if not (size > 0.0).all():
        return float("inf")
    values = np.linalg.eigvalsh(gramian / np.outer(size, size))
    return float(values[-1] / values[0]) if values[0] > 1e-14 * values[-1] else float("inf")


def _over(A: np.ndarray, Q: np.ndarray, horizon: float) -> np.ndarray:
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
    return np.asarray(0.5 * (gramian + gramian.T))


DECAY = 1e-7
"""Decay rate over the magnitude of the fastest eigenvalue, from which on a mode counts as decaying [-]."""

_MINIMAL = 1e-11


@dataclass(frozen=True, eq=False)
class Balanced:
    """A system in balanced coordinates z = to x, x = back z.

    Args:
        system: in balanced coordinates; modes that do not decay first, then the others by falling Hankel values
        to, back: (k, n) and (n, k); k is below n where a part of the state is not controllable or not observable
        hankel: Hankel singular values of the decaying part
        kept: number of the first states, which do not decay
    """

    system: LinearSystem
    to: np.ndarray
    back: np.ndarray
    hankel: np.ndarray
    kept: int


def balanced(system: LinearSystem, shift: float | None = None) -> Balanced:
    """Balance the decaying part by square roots of both Gramians; modes that do not decay are separated from it first.

    Args:
        system: continuous, inputs and outputs in units of their typical size
        shift: decay rate that is added to all modes to balance the whole system [1/s]; None for a separation instead

    Raises:
        ParameterError: a shift with which some mode still does not decay, no state that is both controllable and
            observable, or as `parted`

    Source: B. C. Moore, 1981; square roots as M. S. Tombs, I. Postlethwaite, 1987.
    """
    n = len(system.A)
    if shift is None:
        fastest = float(np.abs(np.linalg.eigvals(system.A)).max())
        first, back, kept = parted(system, lambda value: value.real > -DECAY * fastest)
        if kept == n:
            return Balanced(system, np.eye(n), np.eye(n), np.zeros(0), n)
    else:
        first, back, kept = np.eye(n), np.eye(n), 0
    part = replace(
        system,
        A=(first @ system.A @ back)[kept:, kept:] - (shift or 0.0) * np.eye(n - kept),
        B=(first @ system.B)[kept:],
        C=(system.C @ back)[:, kept:],
    )
    into, out, hankel = _square_roots(part)
    to = np.vstack([first[:kept], into @ first[kept:]])
    out = np.hstack([back[:, :kept], back[:, kept:] @ out])
    form = replace(
        system,
        A=to @ system.A @ out,
        B=to @ system.B,
        C=system.C @ out,
        states=tuple(f"mode {k + 1}" for k in range(len(to))),
    )
    return Balanced(form, to, out, hankel, kept)


def parted(system: LinearSystem, stays: Callable[[complex], bool]) -> tuple[np.ndarray, np.ndarray, int]:
    """Coordinates in which A is block-diagonal with two blocks.

    Args:
        system: continuous or discrete
        stays: whether an eigenvalue belongs to the first block

    Returns:
        to and back (z = to x, x = back z), and the size of the first block

    Raises:
        ParameterError: both blocks share an eigenvalue
    """
    from scipy.linalg import schur, solve_sylvester

    scale = balance(system.A)
    triangle, turn, kept = schur(
        system.A * scale / scale[:, None], output="real", sort=lambda re, im: stays(complex(re, im))
    )
    n = len(system.A)
    coupling = np.eye(n)
    if 0 < kept < n:
        try:
            coupling[:kept, kept:] = solve_sylvester(
                triangle[:kept, :kept], -triangle[kept:, kept:], -triangle[:kept, kept:]
            )
        except np.linalg.LinAlgError as error:
            raise ParameterError(f"the system cannot be split: {error}; choose another order") from None
    back = scale[:, None] * turn @ coupling
    inverse = 2.0 * np.eye(n) - coupling  # of a matrix [I, X; 0, I]: [I, -X; 0, I]
    return inverse @ turn.T / scale, back, kept


def _square_roots(part: LinearSystem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Transformations to and from balanced coordinates, and the Hankel singular values above rounding errors."""
    reached = _root(controllability_gramian(part))
    shown = _root(observability_gramian(part))
    left, values, right = np.linalg.svd(shown.T @ reached)
    count = int(np.count_nonzero(values > _MINIMAL * values[0])) if values[0] > 0.0 else 0
    if not count:
        raise ParameterError("no state is both controllable and observable; choose other inputs or outputs")
    size = np.sqrt(values[:count])
    return left[:, :count].T @ shown.T / size[:, None], reached @ right[:count].T / size, values[:count]


def _root(gramian: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
