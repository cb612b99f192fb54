"""Regressions between the signals of a drive, with covariances valid for autocorrelated residuals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

BLOCK: Annotated[float, "s"] = 0.5
"""Averaging time of a block; long against the delays of sensors, short against a turn."""

STRETCH = 4
"""Blocks per stretch at the start, 2 s; doubled whenever `MOST` stretches are full."""

MOST = 64
"""Largest number of stretches; a covariance needs some twenty, and memory must stay bounded on a long drive."""

FEWEST_BLOCKS, FEWEST_STRETCHES = 15, 6
"""Least numbers for a regression: 7.5 s, in six stretches that count as independent."""

CONDITION = 1e4
"""Largest condition number of the normal equations; beyond it the coefficients are not separable."""


class Relation(NamedTuple):
    """Result of a regression.

    Args:
        values: coefficients, (coefficients,)
        covariance: covariance of the coefficients
        tolerance: share of each regressor's mean square that the others do not explain, 1/VIF, (coefficients,)
    """

    values: np.ndarray
    covariance: np.ndarray
    tolerance: np.ndarray


class BlocksOverDrive:
    """Fixed blocks of a drive, independent of how it is cut.

    Args:
        rate: sampling rate [Hz]
        signals: number of signals
        seconds: averaging time of a block [s]
        fewest: least number of samples of a block
    """

    def __init__(self, rate: float, signals: int, seconds: float = BLOCK, fewest: int = 2):
        self._size = max(round(seconds * rate), fewest)
        self.seconds = self._size / rate
        self._rest = np.empty((0, signals))

    def add(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Blocks that the next samples complete (m, samples, signals), and the changes over them, (m, signals).

        Args:
            rows: the next samples (n, signals)
        """
        rows, size = np.vstack([self._rest, rows]), self._size
        # The change over a block needs the sample after it, so a block waits for the next piece.
        count = max(len(rows) - 1, 0) // size
        self._rest = rows[count * size :]
        changes = rows[size::size][:count] - rows[: count * size : size]
        return rows[: count * size].reshape(count, size, rows.shape[1]), changes


class RelationOverDrive:
    """One regression over a drive: products of regressors and target, accumulated stretch by stretch.

    The result does not depend on how the recording is cut.

    Args:
        coefficients: number of coefficients
    """

    def __init__(self, coefficients: int):
        self._sums = np.zeros((MOST, coefficients + 1, coefficients + 1))
        self._counts = np.zeros(MOST)
        self._blocks, self._length = 0, STRETCH

    def add(self, regressors: Sequence[np.ndarray], target: np.ndarray, counted: np.ndarray) -> None:
        """Add the next blocks, (n,) each.

        Args:
            regressors: one array per coefficient; NaN where missing
            target: NaN where missing
            counted: blocks that may count
        """
        rows = np.column_stack([*regressors, target])
        used = counted & np.isfinite(rows).all(axis=1)
        rows = np.where(used[:, None], rows, 0.0)
        # Excluded rows stay as zeros, so that stretches keep their length in time.
        while len(rows):
            room = MOST * self._length - self._blocks
            at = (self._blocks + np.arange(min(len(rows), room))) // self._length
            part = rows[: len(at)]
            np.add.at(self._sums, at, part[:, :, None] * part[:, None, :])
            np.add.at(self._counts, at, used[: len(at)])
            self._blocks += len(at)
            rows, used = rows[len(at) :], used[len(at) :]
            if self._blocks == MOST * self._length:
                self._join()

    def _join(self) -> None:
        """Merge pairs of stretches, which frees half of them and doubles their length."""
        for kept in (self._sums, self._counts):
            half = kept[0::2] + kept[1::2]
            kept[:] = 0.0
            kept[: MOST // 2] = half
        self._length *= 2

    def found(self, least: float = 0.0) -> Relation | None:
        """The regression; None with too little driving, or with too little motion to separate the coefficients.

        Args:
            least: least standard deviation of the first regressor beside a last one of ones [its unit]; noise in a
                smaller regressor makes its coefficient too small (W. A. Fuller, Measurement Error Models (1987),
                section 1.1)

        Covariance of a sum of scores that are independent from stretch to stretch only: P. J. Huber, Fifth Berkeley
        Symposium 1 (1967) 221; K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986) 13.
        """
        used = self._counts > 0.0
        total = self._sums.sum(axis=0)
        normal, right = total[:-1, :-1], total[:-1, -1]
        size = np.sqrt(np.diag(normal))
        stretches = int(used.sum())
        if self._counts.sum() < FEWEST_BLOCKS or stretches < FEWEST_STRETCHES or not np.all(size > 0.0):
            return None
        if least and normal[0, 0] - normal[0, -1] ** 2 / normal[-1, -1] < least**2 * normal[-1, -1]:
            return None
        if np.linalg.cond(normal / np.outer(size, size)) > CONDITION:
            return None
        inverse = np.linalg.inv(normal)
        values = inverse @ right
        scores = self._sums[used][:, :-1, -1] - self._sums[used][:, :-1, :-1] @ values
        # Clustered (sandwich) covariance, with the usual correction for few clusters.
        few = stretches / max(stretches - len(values), 1)
        tolerance = 1.0 / (np.diag(inverse) * np.diag(normal))
        return Relation(values, few * inverse @ (scores.T @ scores) @ inverse, tolerance)
