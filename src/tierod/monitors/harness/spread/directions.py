"""In which directions parameters move a result: principal directions of its sensitivities.

Twenty uncertain parameters need not be carried through a recording one by one. Over a first stretch each is moved by
one standard deviation alone. The matrix of what that does to the result, in its own standard deviations, has few
principal directions that matter; along those, all parameters together are moved over the whole recording.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

SMALLEST = 0.1
"""Share of its own standard deviation by which a result must move before a parameter counts: less adds half a per cent
to the band."""

SCREENED = 0.03
"""The same share at which a parameter is carried on after the first stretch: a band may become three times narrower."""

CAPTURED = 0.85
"""Share of the variance of the moved result that the directions must hold, if they are not too many; what they leave
is made up for by a wider move."""


class Direction(NamedTuple):
    """Parameters that are moved together.

    Args:
        by: standard deviations by name of the parameter; of length 1
        share: of the variance of the moved result [0 to 1]
    """

    by: Mapping[str, float]
    share: float


class Sensitivities:
    """Sensitivities of a result to parameters over a stretch of a recording, piece by piece.

    Args:
        names: of the parameters
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
        """The next samples.

        Args:
            moves: of the result with each parameter, in its own standard deviations [], (names, n)
        """
        self._grams.append(np.einsum("in,jn->ij", moves, moves))
        self._counts.append(moves.shape[1])

    def _gram(self) -> np.ndarray:
        """Mean products over the later half of the samples: the first ones show the start of the filter."""
        total, size, count = np.zeros((len(self.names), len(self.names))), 0, self.known
        for gram, samples in zip(reversed(self._grams), reversed(self._counts), strict=True):
            if size and 2 * size >= count:
                break
            total, size = total + gram, size + samples
        return total / max(size, 1)

    def moves(self) -> dict[str, float]:
        """Root mean square by which each parameter moves the result, in its own standard deviations []."""
        return dict(zip(self.names, np.sqrt(np.diag(self._gram())).tolist(), strict=True))

    def shares(self, directions: Mapping[int, Direction]) -> dict[int, float]:
        """Shares of the variance of the moved result, by place of a direction; empty where nothing moves it.

        Args:
            directions: of length 1, at right angles to each other
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
        """Mask of parameters that move the result by more than can be left out, (names,)."""
        counted: np.ndarray = np.sqrt(np.diag(self._gram())) > SCREENED
        return counted

    @property
    def any_counted(self) -> bool:
        """Whether a parameter moves the result."""
        return bool(self.known and self._counted().any())

    def directions(self, most: int) -> tuple[Direction, ...]:
        """The directions that hold the most; none where no parameter moves the result.

        Args:
            most: of them
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
