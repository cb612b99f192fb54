"""Coordinates in which a linear system is balanced: reached by its inputs as much as shown by its outputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.analysis.gramian import controllability_gramian, observability_gramian
from tierod.models.linear import LinearSystem
from tierod.models.modes import balance

DECAY = 1e-7
"""Real part, as a share of the fastest eigenvalue, from which on a mode counts as decaying."""

_MINIMAL = 1e-11


@dataclass(frozen=True, eq=False)
class Balanced:
    """A system in balanced coordinates z = to x, x = back z.

    Args:
        system: in them; what does not decay first, then the rest with falling Hankel values
        to, back: (k, n) and (n, k); k is below n where inputs do not reach, or outputs do not show, some of the state
        hankel: singular values of the part that decays
        kept: states at the beginning that do not decay
    """

    system: LinearSystem
    to: np.ndarray
    back: np.ndarray
    hankel: np.ndarray
    kept: int


def balanced(system: LinearSystem, shift: float | None = None) -> Balanced:
    """Balance what decays, by square roots of both Gramians; what does not decay is parted from it first.

    Args:
        system: continuous, inputs and outputs in units of their typical size
        shift: None to part; else all is balanced together, as if each mode decayed faster by so much [1/s]

    Raises:
        ParameterError: a shift that does not make all of it decay

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
    """Coordinates in which A falls into two blocks that do not touch each other.

    Args:
        system: any
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
            raise ParameterError(f"the system cannot be parted: {error}; choose another order") from None
    back = scale[:, None] * turn @ coupling
    inverse = 2.0 * np.eye(n) - coupling
    return inverse @ turn.T / scale, back, kept


def _square_roots(part: LinearSystem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """To and back of the balanced coordinates, and the Hankel singular values, those of rounding left out."""
    reached = _root(controllability_gramian(part))
    shown = _root(observability_gramian(part))
    left, values, right = np.linalg.svd(shown.T @ reached)
    count = int(np.count_nonzero(values > _MINIMAL * values[0])) if values[0] > 0.0 else 0
    if not count:
        raise ParameterError("the inputs reach nothing that the outputs show; choose other inputs or outputs")
    size = np.sqrt(values[:count])
    return left[:, :count].T @ shown.T / size[:, None], reached @ right[:count].T / size, values[:count]


def _root(gramian: np.ndarray) -> np.ndarray:
    """R with R R' = gramian, also where rounding left it not quite definite."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return vectors * np.sqrt(np.maximum(values, 0.0))
