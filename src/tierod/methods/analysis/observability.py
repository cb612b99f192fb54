"""What the outputs of a linear system, or of any model at a point, show of its state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tierod.core.block import Tree
from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, linearise
from tierod.models.modes import TOLERANCE, Mode, describe, modes, scaled


@dataclass(frozen=True, eq=False)
class Observability:
    """How much of a state is shown by the outputs.

    Args:
        states: names
        rank: dimension of the observable subspace, to the tolerance
        tolerance: relative size below which a direction counts as not shown
        singular_values: of the orthonormal observability staircase, largest first, scaled (n,); what lies between
            the last one counted and the first one not is the margin of the rank
        hidden: directions that are not shown, in the states' own units, columns with largest entry 1, (n, n - rank)
        modes: eigenvalues with their margin (PBH test), the least visible first
    """

    states: tuple[str, ...]
    rank: int
    tolerance: float
    singular_values: np.ndarray
    hidden: np.ndarray
    modes: tuple[Mode, ...]

    @property
    def complete(self) -> bool:
        """Whether the whole state is shown."""
        return self.rank == len(self.states)

    def sentence(self) -> str:
        """The result in words, with the directions that are hidden."""
        n = len(self.states)
        if self.complete:
            return f"rank {self.rank} of {n}: the outputs show every state"
        directions = "; ".join(describe(column, self.states) for column in self.hidden.T)
        return f"rank {self.rank} of {n} (tolerance {self.tolerance:g}): the outputs do not show {directions}"


def observability(system: LinearSystem, tolerance: float = TOLERANCE, state_scale: Any = None) -> Observability:
    """Rank of (A, C), singular values, hidden directions and PBH margins.

    A is shifted by its mean eigenvalue and scaled to size 1, states are balanced, outputs are scaled to size 1: none of
    it changes what is observable, all of it keeps rounding from hiding or inventing a rank. The rank comes from the
    staircase of orthonormal bases, not from powers of A.

    Args:
        system: continuous or discrete
        tolerance: relative size below which a direction counts as not shown; 1e-9 leaves six digits for rounding.
            A model known to three digits wants 1e-3: the rank that survives its errors
        state_scale: typical size of each state [its unit], (n,); balanced from A where None

    Raises:
        ParameterError: a scale that is not positive, or a tolerance outside (0, 1)

    Source: staircase, P. Van Dooren, 1981, doi 10.1109/TAC.1981.1102559; PBH test, M. L. J. Hautus, 1969.
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


def observability_of(
    model: Any, parameters: Any, state: Tree, inputs: Tree, tolerance: float = TOLERANCE, state_scale: Any = None
) -> Observability:
    """`observability` of any model, linearised at a point; arguments as there and in `linearise`."""
    return observability(linearise(model, parameters, state, inputs), tolerance, state_scale)


def _readable(basis: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Columns that span the same space in the states' own units, each with entries that the others have not."""
    from scipy.linalg import qr

    count = basis.shape[1]
    if not count:
        return basis
    pivots = np.sort(qr(basis.T, pivoting=True)[2][:count])
    columns = basis @ np.linalg.inv(basis[pivots])
    columns = np.where(np.abs(columns) > TOLERANCE, columns, 0.0) * scale[:, None]
    return columns / np.abs(columns).max(axis=0)


def _staircase(A: np.ndarray, C: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal rows that span what the outputs show, and the singular value that each new row came with."""
    n = len(A)
    seen = np.zeros((0, n))
    values: list[float] = []
    new = C
    while len(new) and len(seen) < n:
        rest = new - (new @ seen.T) @ seen
        rest = rest - (rest @ seen.T) @ seen
        _, sizes, rows = np.linalg.svd(rest, full_matrices=False)
        keep = sizes > tolerance
        values += sizes.tolist()
        seen = np.vstack([seen, rows[keep]])
        new = rows[keep] @ A
    padded = np.sort(np.array(values))[::-1][:n]
    return seen[:n], np.pad(padded, (0, n - len(padded)))
