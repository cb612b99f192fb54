"""First-passage time of a random walk between two limits: run lengths of stopping rules on white Gaussian residuals."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tierod.core.errors import ParameterError

LONGEST = 1e11  # Run length up to which eight digits are correct for sums and five for averages [samples]

WIDEST = 20_000.0  # Largest distance of the limits for which the equations are solved [standard deviations of a step]

PANEL, POINTS = 5.0, 16
"""Width of a panel of the quadrature [standard deviations of a step], and its number of nodes: more change no digit."""

REACH = 9.5  # Longest step of the chain [standard deviations]; longer ones have a probability of less than 1e-20


@dataclass(frozen=True)
class Walk:
    """A random walk: the next value is factor times the present one, plus a Gaussian step."""

    lower: float  # lower, upper: limits; reaching the upper one ends the walk
    upper: float
    restart: bool  # whether reaching the lower one resets the walk to zero; otherwise it ends the walk
    factor: float  # 1 for a sum, below 1 for a geometric average
    mean: float
    deviation: float


@lru_cache(maxsize=4096)
def run_length(walk: Walk, start: float = 0.0) -> float:
    """Expected number of steps until a walk ends; infinite where it is far beyond `LONGEST`.

    The walk is a Markov chain on the nodes of a composite Gauss quadrature. One step leads only to nearby nodes, so
    that the equations are banded. The probability of ending is summed directly, never as one minus the probability of
    continuing, so that no digits are lost however rare the end is.

    Raises:
        ParameterError: a start outside the limits, a step without spread, or limits too far apart

    Source: E. S. Page, 1954; D. Brook, D. A. Evans, 1972, doi 10.1093/biomet/59.3.539; quadrature after L. C. Vance,
    1986.
    """
    if not (walk.lower <= start <= walk.upper and walk.deviation > 0.0):
        raise ParameterError(f"the walk {walk} cannot start at {start}; expected a start between the limits")
    if (apart := (walk.upper - walk.lower) / walk.deviation) > WIDEST:
        raise ParameterError(
            f"the limits are {apart:.3g} standard deviations of a step apart; expected {WIDEST:g} at most: look for a "
            "larger shift, or allow more false alarms"
        )
    found = _renewed(walk, start) if walk.restart else _ending(walk, start)
    return found if 0.0 < found < 100.0 * LONGEST else math.inf


def _renewed(walk: Walk, start: float) -> float:
    """Run length of a walk that restarts at zero: mean length of one cycle over its probability to end at the top."""
    chain = _Chain(walk)
    tries = chain.solve(np.column_stack([np.ones(len(chain.at)), chain.above(chain.at), chain.below(chain.at)]))

    def ahead(value: float) -> tuple[float, float, float]:
        length, ended, back = chain.steps(value) @ tries
        return 1.0 + length, chain.above(value) + ended, chain.below(value) + back

    length, ended, _ = ahead(0.0)
    if not ended > 0.0:
        return math.inf
    first, _, back = ahead(start)
    return float(first + back * length / ended)


def _ending(walk: Walk, start: float) -> float:
    """Run length of a walk that ends at both limits.

    Long run lengths do not depend on the start, and rounding errors then affect one number only, the rate of ending. It
    is recomputed as the probability of ending in one step, averaged over the quasi-stationary distribution of the walk.
    """
    chain = _Chain(walk)
    lengths = chain.solve(np.ones(len(chain.at)))
    scale = 1.0
    if not 0.0 < np.max(lengths) < 1e6:
        found = np.ones(len(chain.at))
        for _ in range(3):
            found = chain.solve(found / np.max(np.abs(found)), transposed=True)
        ends = chain.above(chain.at) + chain.below(chain.at)
        scale = float(found.sum() / (found @ ends) * found.sum() / (found @ lengths))
    return float(1.0 + scale * (chain.steps(start) @ lengths))


class _Chain:
    """The Markov chain of a walk on the nodes: probabilities of one step, and sums over all future steps."""

    def __init__(self, walk: Walk) -> None:
        width = walk.upper - walk.lower
        panels = max(math.ceil(width / (PANEL * walk.deviation)), 1)
        nodes, weights = _gauss(POINTS)
        self.walk, self._edge = walk, width / panels
        self.at = (walk.lower + self._edge * (np.arange(panels)[:, None] + 0.5 * (nodes + 1.0))).ravel()
        self._weights = np.tile(0.5 * self._edge * weights, panels) / (walk.deviation * math.sqrt(2.0 * math.pi))
        self.solve = self._solver()

    def steps(self, value: float) -> np.ndarray:
        return self._density(self.at - self._centre(value)) * self._weights

    def above(self, value: np.ndarray | float) -> np.ndarray | float:
        return self._tail(self._centre(value) - self.walk.upper)

    def below(self, value: np.ndarray | float) -> np.ndarray | float:
        return self._tail(self.walk.lower - self._centre(value))

    def _centre(self, value: np.ndarray | float) -> np.ndarray | float:
        return self.walk.factor * value + self.walk.mean

    def _density(self, distance: np.ndarray) -> np.ndarray:
        step = distance / self.walk.deviation
        return np.exp(-0.5 * step * step)

    def _tail(self, distance: np.ndarray | float) -> np.ndarray | float:
        from scipy.special import ndtr

        tail: np.ndarray | float = ndtr(distance / self.walk.deviation)
        return tail

    def _solver(self) -> Callable[..., np.ndarray]:
        """Solver of (1 - chain) x = b, or its transpose, by a banded LU factorisation."""
        from scipy.linalg.lapack import dgbtrf, dgbtrs

        count, centre = len(self.at), np.asarray(self._centre(self.at))
        reach = REACH * self.walk.deviation + float(np.max(np.abs(centre - self.at)))
        half = min(POINTS * (math.ceil(reach / self._edge) + 1), count - 1)
        rows = np.arange(-half, half + 1)[:, None] + np.arange(count)
        inside = (rows >= 0) & (rows < count)
        band = np.zeros((3 * half + 1, count))
        chances = self._density(self.at - centre[np.clip(rows, 0, count - 1)]) * self._weights
        band[half:] = np.where(inside, -chances, 0.0)
        band[2 * half] += 1.0
        factors, pivots, _ = dgbtrf(band, half, half, overwrite_ab=True)

        def solve(given: np.ndarray, transposed: bool = False) -> np.ndarray:
            return np.asarray(dgbtrs(factors, half, half, given, pivots, trans=int(transposed))[0])

        return solve


@lru_cache(maxsize=4)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(count)
