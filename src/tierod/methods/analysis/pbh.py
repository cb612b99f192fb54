"""The test of Popov, Belevitch and Hautus, eigenvalue by eigenvalue."""

from __future__ import annotations

import numpy as np

from tierod.models.linear import LinearSystem
from tierod.models.modes import scaled

TOLERANCE = 1e-7
"""Size, of the scaled system, below which an eigenvector counts as hidden: rounding moves a double one by 1e-8."""

CLUSTER = 1e-4
"""Eigenvalues nearer to each other than this share of the system's size count as one: rounding splits a triple one by
so much; their mean it leaves alone."""


def pbh_rank(system: LinearSystem) -> int:
    """States less the hidden eigenvectors: rank of [A - eigenvalue I; C], its defects summed over all eigenvalues.

    Validity: it is the number of states if and only if all are shown. Otherwise it bounds the rank from above: of an
    eigenvalue that is there several times the test sees eigenvectors alone, not those that lead to them.

    Source: M. L. J. Hautus, 1969.
    """
    A, C, *_ = scaled(system)
    n = len(A)
    hidden = 0
    for eigenvalue in _distinct(np.linalg.eigvals(A)):
        pencil = np.vstack([A - eigenvalue * np.eye(n), C])
        hidden += int(np.count_nonzero(np.linalg.svd(pencil, compute_uv=False) < TOLERANCE))
    return n - hidden


def _distinct(eigenvalues: np.ndarray) -> list[complex]:
    """The means of eigenvalues that lie together."""
    left, means = list(eigenvalues), []
    while left:
        together = [value for value in left if abs(value - left[0]) < CLUSTER]
        means.append(complex(np.mean(together)))
        left = [value for value in left if abs(value - left[0]) >= CLUSTER]
    return means
