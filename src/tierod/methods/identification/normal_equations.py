"""Least squares from products that were summed over a drive, refused where they do not determine the parameters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Solution(NamedTuple):
    """Parameters of a linear regression.

    Args:
        values: in the order of the regressors, (n,)
        deviations: standard deviations for white residuals, (n,)
        left: sum of the squared residuals
    """

    values: np.ndarray
    deviations: np.ndarray
    left: float


def solved(normal: np.ndarray, right: np.ndarray, power: float, count: float, worst: float = 1e8) -> Solution | None:
    """Solution of the normal equations; None where a regressor is zero or they are nearly dependent.

    Args:
        normal: sums of the products of the regressors, (n, n)
        right: sums of their products with what they explain, (n,)
        power: sum of its squares
        count: of the samples
        worst: greatest condition number of the equations, scaled to equal regressors []
    """
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > worst:
        return None
    values = np.linalg.solve(normal, right)
    left = max(float(power - values @ right), 0.0)
    return Solution(values, np.sqrt(left / count * np.diag(np.linalg.inv(normal))), left)
