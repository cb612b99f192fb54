"""Regression with instruments: consistent where the regressors are noisy themselves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.identification.long_run import sandwich


class Regression(NamedTuple):
    """What a regression found.

    Args:
        values: coefficients
        covariance: of them, with residuals that are coloured
        residual: root mean square of what is left over
        inverse: of instruments against regressors, (coefficients, coefficients)
        strength: smallest singular value of instruments against regressors, each of size one: 0 is no information
    """

    values: np.ndarray
    covariance: np.ndarray
    residual: float
    inverse: np.ndarray
    strength: float


def instrumental(
    target: Sequence[np.ndarray], regressors: Sequence[np.ndarray], instruments: Sequence[np.ndarray]
) -> Regression:
    """Coefficients c of target = regressors c, over several experiments.

    Args:
        target: one array (n,) per experiment
        regressors: one array (n, coefficients) per experiment; noisy
        instruments: the same shapes: like the regressors, but with noise of their own

    Raises:
        InputError: instruments that do not move with the regressors

    Source: T. Soderstrom, P. Stoica, Instrumental Variable Methods for System Identification (1983), chapter 4.
    """
    shown, seen, told = map(np.concatenate, (regressors, instruments, target))
    cross = seen.T @ shown
    sizes = np.outer(np.linalg.norm(seen, axis=0), np.linalg.norm(shown, axis=0))
    strength = float(np.linalg.svd(cross / np.where(sizes > 0.0, sizes, np.inf), compute_uv=False)[-1])
    if not strength > 1e-6:
        raise InputError("the instruments do not move with the regressors; record a test with more motion")
    values = np.linalg.solve(cross, seen.T @ told)
    left = [t - r @ values for t, r in zip(target, regressors, strict=True)]
    scores = [z * e[:, None] for z, e in zip(instruments, left, strict=True)]
    inverse = np.linalg.inv(cross)
    whitened = [score @ inverse.T for score in scores]
    covariance = sandwich(np.eye(len(values)), whitened)
    residual = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    return Regression(values, covariance, residual, inverse, strength)
