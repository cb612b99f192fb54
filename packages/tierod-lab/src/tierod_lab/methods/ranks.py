"""Ranks of observability as papers compute them: by the PBH test and by the observability matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tierod.core.errors import ParameterError
from tierod.models.linear import TOLERANCE, LinearSystem, Mode, describe, modes, scaled

PBH_TOLERANCE = 1e-7
"""Singular value below which an eigenvector is unobservable (scaled system): rounding moves a double one by 1e-8."""
CLUSTER = 1e-4
"""Distance below which eigenvalues of the scaled system count as one: rounding splits a triple eigenvalue by as much,
but hardly moves the mean."""


def pbh_rank(system: LinearSystem) -> int:
    """PBH test: number of states less the rank defects of [A - eigenvalue I; C] over all eigenvalues.

    Validity: it is the number of states if and only if all are observable. Otherwise it is an upper bound of the rank:
    for a multiple eigenvalue the test covers eigenvectors, but not generalised eigenvectors.

    Source: M. L. J. Hautus, 1969.
    """
    A, C, *_ = scaled(system)
    left, hidden = list(np.linalg.eigvals(A)), 0
    while left:
        eigenvalue = np.mean([value for value in left if abs(value - left[0]) < CLUSTER])
        left = [value for value in left if abs(value - left[0]) >= CLUSTER]
        pencil = np.vstack([A - eigenvalue * np.eye(len(A)), C])
        hidden += int(np.count_nonzero(np.linalg.svd(pencil, compute_uv=False) < PBH_TOLERANCE))
    return len(A) - hidden


def default_rank(matrix: np.ndarray) -> int:
    """Rank with MATLAB's default tolerance: larger dimension times spacing of floats at the largest singular value."""
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.count_nonzero(values > max(matrix.shape) * np.spacing(values[0])))


def observability_matrix(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Observability matrix [C; CA; ...; CA^(n-1)], each block from the one before it, as MATLAB's `obsv` does."""
    blocks = [C]
    for _ in range(len(A) - 1):
        blocks.append(blocks[-1] @ A)
    return np.vstack(blocks)


def unscaled_rank(system: LinearSystem) -> int:
    """Rank of the observability matrix in the units of the system, `rank(obsv(A, C))` of MATLAB.

    Validity: powers of A grow with the fastest eigenvalue. Where fast and slow modes are three decades apart, six
    states suffice to move the slow ones below rounding: the rank then depends on the units more than on the system.
    `observability` and `scaled_rank` do not depend on units.
    """
    return default_rank(observability_matrix(system.A, system.C))


def scaled_rank(system: LinearSystem) -> int:
    """Rank of the observability matrix of the balanced, shifted and normalised system, see `models.linear.scaled`."""
    form = scaled(system)
    return default_rank(observability_matrix(form.A, form.C))


@dataclass(frozen=True, eq=False)
class Observability:
    """Observability of a state through the outputs."""

    states: tuple[str, ...]
    rank: int  # dimension of the observable subspace, to the tolerance
    tolerance: float  # relative size below which a direction counts as unobservable
    # of the orthonormal observability staircase, largest first, scaled (n,); the gap at the tolerance is the margin of
    # the rank
    singular_values: np.ndarray
    hidden: np.ndarray  # unobservable directions in the states' own units, columns with largest entry 1, (n, n - rank)
    modes: tuple[Mode, ...]  # eigenvalues with their margin (PBH test), the least observable first

    @property
    def complete(self) -> bool:
        """Whether every state is observable."""
        return self.rank == len(self.states)

    def sentence(self) -> str:
        """The result in words, with the unobservable directions."""
        n = len(self.states)
        if self.complete:
            return f"rank {self.rank} of {n}: every state is observable"
        directions = "; ".join(describe(column, self.states) for column in self.hidden.T)
        return f"rank {self.rank} of {n} (tolerance {self.tolerance:g}): not observable: {directions}"


def observability(
    system: LinearSystem, tolerance: float = TOLERANCE, state_scale: ArrayLike | None = None
) -> Observability:
    """Observability of (A, C): rank, singular values, unobservable directions and PBH margins.

    A is shifted by its mean eigenvalue and scaled to norm 1, states are balanced, outputs are scaled to norm 1. This
    does not change the observable subspace, and protects the rank from rounding errors. The rank comes from the
    staircase of orthonormal bases, not from powers of A.

    Source: staircase, P. Van Dooren, 1981, doi 10.1109/TAC.1981.1102559; PBH test, M. L. J. Hautus, 1969. Args:
    tolerance: relative size below which a direction counts as unobservable; 1e-9 leaves six digits for rounding. A
    model with parameters of three digits needs 1e-3: the rank that holds in spite of their errors; state_scale: typical
    size of each state [its unit], (n,); balanced from A where None.
    """
    if not 0.0 < tolerance < 1.0:
        raise ParameterError(f"tolerance is {tolerance}; expected a number between 0 and 1")
    n = len(system.A)
    if state_scale is not None:
        state_scale = np.asarray(state_scale, float)
        if state_scale.shape != (n,) or not (np.isfinite(state_scale) & (state_scale > 0.0)).all():
            raise ParameterError(f"state_scale needs a number above zero for each of {', '.join(system.states)}")
    form = scaled(system, state_scale)
    seen, values = _staircase(form.A, form.C, tolerance)
    hidden = np.linalg.svd(seen)[2][len(seen) :].T if len(seen) else np.eye(n)
    return Observability(
        system.states,
        len(seen),
        tolerance,
        values,
        _readable(hidden, form.scale),
        tuple(modes(system, state_scale)),
    )


def _readable(basis: np.ndarray, scale: np.ndarray) -> np.ndarray:
    from scipy.linalg import qr

    count = basis.shape[1]
    if not count:
        return basis
    pivots = np.sort(qr(basis.T, pivoting=True)[2][:count])
    columns = basis @ np.linalg.inv(basis[pivots])
    columns = np.where(np.abs(columns) > TOLERANCE, columns, 0.0) * scale[:, None]
    return np.asarray(columns / np.abs(columns).max(axis=0))


def _staircase(A: np.ndarray, C: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    n = len(A)
    seen = np.zeros((0, n))
    values: list[float] = []
    new = C
    while len(new) and len(seen) < n:
        rest = new - (new @ seen.T) @ seen
        rest = rest - (rest @ seen.T) @ seen  # a second time, since rounding spoils the first for nearly known rows
        _, sizes, rows = np.linalg.svd(rest, full_matrices=False)
        keep = sizes > tolerance
        values += sizes.tolist()
        seen = np.vstack([seen, rows[keep]])
        new = rows[keep] @ A
    padded = np.sort(np.array(values))[::-1][:n]
    return seen[:n], np.pad(padded, (0, n - len(padded)))
