"""Set-membership identification: the smallest box around all parameters that bounded errors allow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError, ParameterError

Array = np.ndarray


class Bounded(NamedTuple):
    """Equations y = regressors p + error with bounded errors.

    Args:
        regressors: (rows, parameters)
        values: y, (rows,)
        bound: largest error independent of the parameters, (rows,)
        slope: largest error per parameter, (rows, parameters): the bound of the error of each regressor
    """

    regressors: Array
    values: Array
    bound: Array
    slope: Array


class Box(NamedTuple):
    """Smallest and largest value of every parameter, (parameters,) each."""

    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        """Centre of the box."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def half_width(self) -> Array:
        """Half width of the box."""
        return np.asarray(0.5 * (self.high - self.low))


def feasible_box(rows: Bounded) -> Box:
    """The smallest box around all nonnegative parameters that equations and bounds allow.

    The set is a polytope: |y - regressors p| <= bound + slope p with p >= 0 is linear in p, and each side of the box is
    the optimum of a linear programme. It is valid if the bounds are: no distribution, independence or number of samples
    is assumed; with fewer rows it is larger, but still valid.

    Raises:
        ParameterError: shapes that differ, or bounds below zero
        InputError: no parameters are feasible, since a bound or the model is wrong; or some parameter is not bounded

    Source: Milanese and Vicino, Automatica 27 (1991) 997, section 3; errors in the regressors as in Cerone, IEEE Trans.
    Automatic Control 38 (1993) 1729, for parameters of known sign.
    """
    from scipy.optimize import linprog

    regressors, values, bound, slope = rows
    if not (regressors.shape == slope.shape and values.shape == bound.shape == regressors.shape[:1]):
        shapes = f"{regressors.shape}, {slope.shape}, {values.shape}, {bound.shape}"
        raise ParameterError(f"regressors, slopes, values and bounds of shapes {shapes} do not match")
    if (bound < 0.0).any() or (slope < 0.0).any():
        raise ParameterError("a bound of an error is below zero; give its largest size")
    scale = np.maximum(np.abs(regressors).max(axis=0, initial=0.0), 1e-300)
    matrix = np.concatenate([regressors - slope, -regressors - slope]) / scale
    right = np.concatenate([values + bound, bound - values])
    ends = []
    for place in range(regressors.shape[1]):
        for sign in (1.0, -1.0):
            cost = np.zeros(regressors.shape[1])
            cost[place] = sign
            found = linprog(cost, A_ub=matrix, b_ub=right, bounds=(0.0, None), method="highs")
            if found.status == 2:
                raise InputError(
                    "no parameters agree with all readings within their bounds: a bound is too small, or the model "
                    "does not hold; give larger bounds, or leave out what it does not describe"
                )
            if found.status != 0:
                raise InputError(
                    f"parameter {place + 1} of {regressors.shape[1]} is not bounded by these readings; record a drive "
                    "that excites it"
                )
            ends.append(sign * found.fun / scale[place])
    return Box(np.array(ends[::2]), np.array(ends[1::2]))
