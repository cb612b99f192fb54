"""How long a random walk stays between two limits: run lengths of stopping rules on white Gaussian residuals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tierod.errors import ParameterError

LONGEST = 1e11
"""Run length up to which the equations are solved [samples]: beyond it they lose the last digits."""

NODES = 3.0
"""Of the quadrature, per standard deviation of a step: the kernel is smooth, and more change nothing in six digits."""


@dataclass(frozen=True)
class Walk:
    """The next value is factor times the present one, plus a Gaussian step.

    Args:
        lower, upper: limits; reaching the upper one ends the walk
        restart: whether reaching the lower one brings the walk back to zero; it ends it otherwise
        factor: 1 for a sum, below it for an average that forgets
        mean, deviation: of the step
    """

    lower: float
    upper: float
    restart: bool
    factor: float
    mean: float
    deviation: float


def run_length(walk: Walk, start: float = 0.0) -> float:
    """Expected number of steps until a walk ends.

    Args:
        walk: its limits and steps
        start: where it begins

    A Markov chain on the nodes of Gauss's quadrature: L(u) = 1 + P(back to zero | u) L(0) + sum of w p(s | u) L(s),
    exact to six digits where the answer is below `LONGEST`.

    Raises:
        ParameterError: a start outside the limits, or a step without spread

    Source: E. S. Page, 1954; D. Brook, D. A. Evans, 1972, doi 10.1093/biomet/59.3.539; quadrature after L. C. Vance,
    1986.
    """
    from scipy.special import ndtr

    if not (walk.lower <= start <= walk.upper and walk.deviation > 0.0):
        raise ParameterError(f"the walk {walk} cannot start at {start}; expected a start between the limits")
    width = walk.upper - walk.lower
    nodes, weights = _gauss(int(np.clip(NODES * width / walk.deviation, 40, 900)))
    at = walk.lower + 0.5 * width * (nodes + 1.0)
    begin = np.append(at, [0.0, start])
    centre = walk.factor * begin + walk.mean
    step = (at[None, :] - centre[:, None]) / walk.deviation
    chain = np.exp(-0.5 * step * step) / (walk.deviation * np.sqrt(2.0 * np.pi)) * (0.5 * width * weights)
    system = np.eye(len(begin))
    system[:, : len(at)] -= chain
    if walk.restart:
        system[:, len(at)] -= ndtr((walk.lower - centre) / walk.deviation)
    solved = np.linalg.solve(system, np.ones(len(begin)))
    found = float(solved[-1])
    return found if 0.0 < found < 100.0 * LONGEST else np.inf


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(count)
