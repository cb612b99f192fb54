"""The observability matrix [C; CA; CA^2; ...] and its rank in double precision, as textbooks and MATLAB take it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.models.linear import LinearSystem
from tierod.models.modes import scaled


class Rank(NamedTuple):
    """Rank of a matrix, and what decided it.

    Args:
        rank: singular values above the tolerance
        tolerance: absolute
        singular_values: largest first
    """

    rank: int
    tolerance: float
    singular_values: np.ndarray

    @property
    def margin(self) -> float:
        """The singular value nearest to the tolerance over it, logarithmically: near 1, rounding decides the rank."""
        values = self.singular_values[self.singular_values > 0.0]
        if not len(values) or self.tolerance == 0.0:
            return float("inf")
        ratios = values / self.tolerance
        return float(ratios[np.argmin(np.abs(np.log(ratios)))])


def default_rank(matrix: np.ndarray) -> Rank:
    """Rank to the default tolerance of MATLAB's `rank`: the longer side times the spacing of numbers at the largest
    singular value."""
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(0)
    tolerance = float(max(matrix.shape) * np.spacing(values[0])) if len(values) else 0.0
    return Rank(int(np.count_nonzero(values > tolerance)), tolerance, values)


def observability_matrix(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """[C; CA; ...; CA^(n-1)], each block from the one before it, as MATLAB's `obsv` does."""
    blocks = [C]
    for _ in range(len(A) - 1):
        blocks.append(blocks[-1] @ A)
    return np.vstack(blocks)


def unscaled_rank(system: LinearSystem) -> Rank:
    """Rank of the observability matrix in the units of the system, `rank(obsv(A, C))` of MATLAB.

    Validity: powers of A grow with the fastest eigenvalue. Where fast and slow modes lie three decades apart, six
    states are enough to push the slow ones below rounding: the rank then says less about the system than about its
    units. `observability` and `scaled_rank` do not depend on them.
    """
    return default_rank(observability_matrix(system.A, system.C))


def scaled_rank(system: LinearSystem) -> Rank:
    """The same rank with states balanced, outputs of size 1, and A without its mean eigenvalue and of size 1."""
    form = scaled(system)
    return default_rank(observability_matrix(form.A, form.C))
