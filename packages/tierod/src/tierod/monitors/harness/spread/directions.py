"""Principal directions of the sensitivities of a result to uncertain parameters.

Twenty uncertain parameters need not be carried through a recording one by one. Over a first stretch each is perturbed
alone, by one standard deviation. The matrix of the resulting changes, in standard deviations of the result, has few
principal directions that matter; along these, all parameters are perturbed together over the whole recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

SMALLEST = 0.1
"""Least change of a result for a parameter to count, in standard deviations of the result [-]: less adds half a per
cent to the band."""

SCREENED = 0.03
"""Least change for which a parameter is followed after the first stretch, in standard deviations of the result [-]: the
band may become three times narrower later."""

CAPTURED = 0.85
"""Share of the variance of the perturbed result that the directions must hold, up to a largest number of them [-]; the
variance is scaled up for the rest."""


class Direction(NamedTuple):
    """Direction in which parameters are perturbed together.

    Args:
        by: components in standard deviations by name of the parameter, a unit vector
        share: share of the variance of the perturbed result [0 to 1]
    """

    by: Mapping[str, float]
    share: float


class Sensitivities:
    """Accumulates the sensitivities of a result to parameters over a stretch of a recording.

    Args:
        names: names of the parameters
    """

    def __init__(self, names: Sequence[str]):
        self.names = tuple(names)
        self._grams: list[np.ndarray] = []
        self._counts: list[int] = []

    @property
    def known(self) -> int:
        """Number of samples with a valid result."""
        return sum(self._counts)

    def add(self, moves: np.ndarray) -> None:
        """Add the next samples.

        Args:
            moves: changes of the result by each parameter, in standard deviations of the result [-], (names, n)
        """
        self._grams.append(np.einsum("in,jn->ij", moves, moves))
        self._counts.append(moves.shape[1])

    def _gram(self) -> np.ndarray:
        """Mean products over the later half of the samples; the first half contains the transient of the filter."""
        total, size, count = np.zeros((len(self.names), len(self.names))), 0, self.known
        for gram, samples in zip(reversed(self._grams), reversed(self._counts), strict=True):
            if size and 2 * size >= count:
                break
            total, size = total + gram, size + samples
        return total / max(size, 1)

    def moves(self) -> dict[str, float]:
        """Root mean square of the change by each parameter, in standard deviations of the result [-]."""
        return dict(zip(self.names, np.sqrt(np.diag(self._gram())).tolist(), strict=True))

    def shares(self, directions: Mapping[int, Direction]) -> dict[int, float]:
        """Shares of the variance of the perturbed result by index of a direction; empty if no parameter counts.

        Args:
            directions: orthonormal directions by index
        """
        gram, counted = self._gram(), self._counted()
        if not counted.any():
            return {}
        gram = np.where(np.outer(counted, counted), gram, 0.0)
        vectors = {
            place: np.array([each.by.get(name, 0.0) for name in self.names]) for place, each in directions.items()
        }
        return {place: float(vector @ gram @ vector / np.trace(gram)) for place, vector in vectors.items()}

    def _counted(self) -> np.ndarray:
        """Mask of the parameters that change the result by more than `SCREENED`, (names,)."""
        counted: np.ndarray = np.sqrt(np.diag(self._gram())) > SCREENED
        return counted

    @property
    def any_counted(self) -> bool:
        """Whether at least one parameter changes the result by more than `SCREENED`."""
        return bool(self.known and self._counted().any())

    def directions(self, most: int) -> tuple[Direction, ...]:
        """Principal directions with the largest shares; none if no parameter counts.

        Args:
            most: largest number of directions
        """
        gram, counted = self._gram(), self._counted()
        if not counted.any():
            return ()
        chosen = np.outer(counted, counted)
        values, vectors = np.linalg.eigh(np.where(chosen, gram, 0.0))
        shares = np.maximum(values[::-1], 0.0) / np.sum(np.maximum(values, 0.0))
        needed = int(np.searchsorted(np.cumsum(shares), CAPTURED)) + 1
        found = []
        for place in range(min(needed, most, int(counted.sum()))):
            vector = vectors[:, ::-1][:, place]
            by = {name: float(part) for name, part in zip(self.names, vector, strict=True) if abs(part) > 1e-3}
            found.append(Direction(by, float(shares[place])))
        return tuple(found)
