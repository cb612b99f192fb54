"""Ranks of observability as papers compute them: by the PBH test and by the observability matrix."""

from __future__ import annotations

import numpy as np

from tierod.models.linear import LinearSystem, scaled

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
