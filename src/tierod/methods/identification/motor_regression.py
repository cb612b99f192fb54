"""Regression in complex numbers with instruments from the past, for signals of one vector in a plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tierod.methods.identification.long_run import sandwich


class Rows(NamedTuple):
    """Equations target = regressors c of one recording, c real; complex rows count twice.

    Args:
        target: (n,)
        regressors: (n, coefficients)
        instruments: the same shape, with noise of their own
    """

    target: np.ndarray
    regressors: np.ndarray
    instruments: np.ndarray


class Fit(NamedTuple):
    """What a regression found.

    Args:
        values: coefficients
        covariance: of them, with residuals that are coloured
        residual: root mean square of what is left over
    """

    values: np.ndarray
    covariance: np.ndarray
    residual: float

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def regress(rows: Sequence[Rows], correction: Sequence[np.ndarray] | None = None) -> Fit:
    """Real coefficients of all rows together.

    The covariance is the larger of the sandwich and of what the coefficients spread without one stretch after the
    other: the sandwich is blind to a coefficient that a single transient tells. Coefficients that the instruments do
    not tell at all come out as zero with an infinite deviation; those whose regressors are nearly a combination of
    others keep their value with an infinite deviation, since the least error of the model would decide between them.

    Args:
        rows: of every recording
        correction: added to the regressors, not to the instruments

    Source: T. Soderstrom, P. Stoica, Instrumental Variable Methods for System Identification (1983), chapter 4; H. R.
    Kuensch, Annals of Statistics 17 (1989) 1217, on stretches left out; D. Belsley, E. Kuh, R. Welsch, Regression
    Diagnostics (1980), ch. 3, on regressors that are nearly combinations of others.
    """
    added = correction or [np.zeros(1)] * len(rows)
    shown = [each.regressors + more for each, more in zip(rows, added, strict=True)]
    cross = sum(np.real(np.conj(r.instruments).T @ f) for r, f in zip(rows, shown, strict=True))
    along = sum(np.real(np.conj(r.instruments).T @ r.target) for r in rows)
    sizes = np.sqrt(np.outer(_power([r.instruments for r in rows]), _power(shown)))
    told = np.diag(cross) > WEAK * np.diag(sizes)
    chosen = np.flatnonzero(told)
    inverse = np.zeros_like(cross)
    if len(chosen):
        scale = np.sqrt(np.diag(sizes))[chosen]
        inner = cross[np.ix_(chosen, chosen)] / np.outer(scale, scale)
        inverse[np.ix_(chosen, chosen)] = np.linalg.pinv(inner, rcond=1e-8) / np.outer(scale, scale)
    values = inverse @ along
    left = [r.target - f @ values for r, f in zip(rows, shown, strict=True)]
    scores = [np.real(np.conj(r.instruments) * e[:, None]) @ inverse.T for r, e in zip(rows, left, strict=True)]
    covariance = _larger(sandwich(np.eye(len(values)), scores), _left_out(rows, shown, values, chosen))
    untold = ~told
    untold[chosen] |= _confused([each[:, chosen] for each in shown])
    covariance[untold, :] = covariance[:, untold] = 0.0
    covariance[untold, untold] = np.inf
    residual = float(np.sqrt(np.mean(np.abs(np.concatenate(left)) ** 2)))
    return Fit(values, covariance, residual)


def _left_out(rows: Sequence[Rows], shown: Sequence[np.ndarray], values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Variances from coefficients without each of some stretches: large where a few samples tell a coefficient."""
    crosses, alongs = [], []
    share = max(1, round(BLOCKS / len(rows)))
    for row, f in zip(rows, shown, strict=True):
        for part in np.array_split(np.arange(len(row.target)), share):
            z = np.conj(row.instruments[part][:, chosen]).T
            crosses.append(np.real(z @ f[part][:, chosen]))
            alongs.append(np.real(z @ row.target[part]))
    cross, along, count = sum(crosses), sum(alongs), len(crosses)
    scale = 1.0 / np.sqrt(np.abs(np.diag(cross)))
    found = []
    for c, a in zip(crosses, alongs, strict=True):
        inner = (cross - c) * np.outer(scale, scale)
        found.append(scale * (np.linalg.pinv(inner, rcond=1e-8) @ (scale * (along - a))))
    out = np.zeros(len(values))
    out[chosen] = (count - 1.0) / count * np.sum((np.array(found) - values[chosen]) ** 2, axis=0)
    return out


def _confused(shown: Sequence[np.ndarray]) -> np.ndarray:
    """Coefficients of which a combination has hardly any regressor left."""
    if not shown[0].shape[1]:
        return np.zeros(0, bool)
    size = np.sqrt(_power(shown))
    together = sum(np.real(np.conj(each).T @ each) for each in shown) / np.outer(size, size)
    values, directions = np.linalg.eigh(together)
    little = values < values[-1] / CONDITION**2
    return np.any(np.abs(directions[:, little]) > _PART, axis=1)


def _larger(covariance: np.ndarray, variances: np.ndarray) -> np.ndarray:
    """A covariance with its variances no less than others, its correlations kept."""
    own = np.diag(covariance)
    factor = np.sqrt(np.maximum(variances / np.where(own > 0.0, own, np.inf), 1.0))
    return covariance * np.outer(factor, factor)


BLOCKS = 20
"""Stretches that are left out one by one."""

CONDITION, _PART = 30.0, 0.3
"""Condition index from which regressors are combinations of others, the usual one; what takes part in a combination."""

WEAK = 0.1
"""Correlation of a regressor with its instrument below which the regressor is noise."""


def _power(parts: Sequence[np.ndarray]) -> np.ndarray:
    return sum(np.sum(np.abs(each) ** 2, axis=0) for each in parts)
