"""Real and complex regression with instrumental variables, its covariances, and modulating functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tierod.core.errors import InputError


@dataclass(frozen=True)
class Modulation:
    """Weighted means over a sliding window; by partial integration, derivatives act on the weight, which is known.

    The weight is sin^4: it and its first three derivatives are zero at the ends, so that no boundary terms remain. Rows
    whose window contains a missing sample are NaN.

    Args:
        step: sampling interval [s]

    Source: M. Shinbrot, Trans. ASME 79 (1957) 547.
    """

    length: int
    stride: int
    step: float

    def growth(self, values: np.ndarray) -> np.ndarray:
        """Mean rate of a signal from its increments; exact for a rate that is constant over a step."""
        return self.between(np.diff(values) / self.step)

    def between(self, values: np.ndarray) -> np.ndarray:
        """Mean of values that belong to the steps between samples, (n - 1,) for a signal of n samples."""
        return self._rows(values, self._steps)

    @property
    def gain(self) -> tuple[float, float]:
        """Standard deviations of `between` [-] and `growth` [1/s] for white noise of standard deviation one."""
        edges = np.diff(np.concatenate([[0.0], self._steps, [0.0]]))
        return float(np.sqrt(np.sum(self._steps**2))), float(np.sqrt(np.sum(edges**2))) / self.step

    def mean(self, values: np.ndarray) -> np.ndarray:
        return self._rows(values, np.sin(self._places) ** 4 * self._scale)

    def rate(self, values: np.ndarray) -> np.ndarray:
        """Mean rate of a signal that is smooth over a window."""
        slope = 4.0 * np.sin(self._places) ** 3 * np.cos(self._places)
        return self._rows(values, -slope * self._scale * self._turn)

    def acceleration(self, values: np.ndarray) -> np.ndarray:
        """Mean second derivative of a signal that is smooth over a window."""
        sine, cosine = np.sin(self._places), np.cos(self._places)
        bend = 12.0 * sine**2 * cosine**2 - 4.0 * sine**4
        return self._rows(values, bend * self._scale * self._turn**2)

    @property
    def _steps(self) -> np.ndarray:
        weight = np.sin(np.pi * (np.arange(self.length) + 0.5) / self.length) ** 4
        return np.asarray(weight / weight.sum())

    @property
    def _places(self) -> np.ndarray:
        return np.pi * np.arange(self.length + 1) / self.length

    @property
    def _scale(self) -> float:
        return 8.0 / (3.0 * self.length)

    @property
    def _turn(self) -> float:
        return float(np.pi / (self.length * self.step))

    def _rows(self, values: np.ndarray, weight: np.ndarray) -> np.ndarray:
        return np.convolve(values, weight[::-1], "valid")[:: self.stride]


def long_run_covariance(scores: Sequence[np.ndarray]) -> np.ndarray:
    """Covariance of the sum of autocorrelated scores, (parameters, parameters).

    Bartlett weights, with the bandwidth of Andrews' rule for first-order autoregression: the largest of all parameters,
    at most a tenth of the shortest experiment.

    Args:
        scores: derivative of the cost of every sample by the parameters, one array (n, parameters) per experiment

    Source: W. K. Newey, K. D. West, Econometrica 55 (1987) 703; D. W. K. Andrews, Econometrica 59 (1991) 817, eq (6.4).
    """
    lags = min(_bandwidth(scores), min(len(each) for each in scores) // 10)
    total = np.zeros((scores[0].shape[1],) * 2)
    for each in scores:
        total += each.T @ each
        for lag in range(1, lags + 1):
            shifted = each[lag:].T @ each[:-lag]
            total += (1.0 - lag / (lags + 1.0)) * (shifted + shifted.T)
    return total


def _bandwidth(scores: Sequence[np.ndarray]) -> int:
    before, after = np.concatenate([each[:-1] for each in scores]), np.concatenate([each[1:] for each in scores])
    power = np.sum(before**2, axis=0)
    correlation = np.sum(before * after, axis=0) / np.where(power > 0.0, power, 1.0)
    correlation = np.clip(correlation, -0.97, 0.97)
    alpha = 4.0 * correlation**2 / (1.0 - correlation**2) ** 2
    return int(np.ceil(1.1447 * (np.max(alpha) * len(before)) ** (1.0 / 3.0)))


def sandwich(
    information: np.ndarray, scores: Sequence[np.ndarray], known_before: np.ndarray | None = None
) -> np.ndarray:
    """Covariance of an estimate: information^-1 J information^-1, J the long-run covariance of the scores.

    Args:
        information: second derivatives of the cost, or their expectation
        known_before: part of `information` that is due to a prior and has no scores

    A coordinate without information (a noise that was estimated as zero) has zero variance.

    Source: P. J. Huber, Fifth Berkeley Symposium 1 (1967) 221.
    """
    diagonal = np.diag(information)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, np.inf))
    inverse = np.linalg.pinv(information * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale)
    middle = long_run_covariance(scores)
    return np.asarray(inverse @ (middle if known_before is None else middle + known_before) @ inverse)


class Regression(NamedTuple):
    """Result of an instrumental-variable regression."""

    values: np.ndarray
    covariance: np.ndarray  # of the coefficients, for autocorrelated residuals
    residual: float
    inverse: np.ndarray  # of the products of instruments and regressors, (coefficients, coefficients)
    strength: float  # smallest singular value of these products, with columns of norm one: 0 is no information


def instrumental(
    target: Sequence[np.ndarray], regressors: Sequence[np.ndarray], instruments: Sequence[np.ndarray]
) -> Regression:
    """Coefficients c of target = regressors c, over several experiments.

    Args:
        target: one array (n,) per experiment
        regressors: one array (n, coefficients) per experiment; noisy
        instruments: one array of the same shape per experiment; correlated with the regressors, with independent noise

    Raises:
        InputError: instruments that do not correlate with the regressors

    Source: T. Soderstrom, P. Stoica, Instrumental Variable Methods for System Identification (1983), chapter 4.
    """
    x, z, y = map(np.concatenate, (regressors, instruments, target))
    cross = z.T @ x
    sizes = np.outer(np.linalg.norm(z, axis=0), np.linalg.norm(x, axis=0))
    strength = float(np.linalg.svd(cross / np.where(sizes > 0.0, sizes, np.inf), compute_uv=False)[-1])
    if not strength > 1e-6:
        raise InputError("the instruments do not move with the regressors; record a test with more motion")
    values = np.linalg.solve(cross, z.T @ y)
    left = [t - r @ values for t, r in zip(target, regressors, strict=True)]
    scores = [z * e[:, None] for z, e in zip(instruments, left, strict=True)]
    inverse = np.linalg.inv(cross)
    whitened = [score @ inverse.T for score in scores]
    covariance = sandwich(np.eye(len(values)), whitened)
    residual = float(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    return Regression(values, covariance, residual, inverse, strength)


class Rows(NamedTuple):
    """Equations target = regressors c of one recording, with real c; a complex row counts as two."""

    target: np.ndarray  # (n,)
    regressors: np.ndarray  # (n, coefficients)
    instruments: np.ndarray  # (n, coefficients), with independent noise


class Fit(NamedTuple):
    """Result of a regression."""

    values: np.ndarray
    covariance: np.ndarray  # of the coefficients, for autocorrelated residuals; infinite variance of unidentified ones
    residual: float

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations of the coefficients."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def regress(rows: Sequence[Rows], correction: Sequence[np.ndarray] | None = None) -> Fit:
    """Real coefficients from the rows of all recordings.

    The variances are the larger of the sandwich estimate and the block jackknife: the sandwich underestimates that of a
    coefficient that depends on a single transient. Coefficients that the instruments do not identify are zero with
    infinite standard deviation. Those whose regressors are nearly collinear keep their value with infinite standard
    deviation, since the smallest model error would decide between them.

    Args:
        correction: added to the regressors, not to the instruments

    Source: T. Soderstrom, P. Stoica, Instrumental Variable Methods for System Identification (1983), chapter 4; H. R.
    Kuensch, Annals of Statistics 17 (1989) 1217, block jackknife; D. Belsley, E. Kuh, R. Welsch, Regression Diagnostics
    (1980), ch. 3, collinearity.
    """
    added = correction or [np.zeros(1)] * len(rows)
    shown = [each.regressors + more for each, more in zip(rows, added, strict=True)]
    cross = sum(np.real(np.conj(r.instruments).T @ f) for r, f in zip(rows, shown, strict=True))
    along = sum(np.real(np.conj(r.instruments).T @ r.target) for r in rows)
    sizes = np.sqrt(np.outer(_power([r.instruments for r in rows]), _power(shown)))
    identified = np.diag(cross) > WEAK * np.diag(sizes)
    chosen = np.flatnonzero(identified)
    inverse = np.zeros_like(cross)
    if len(chosen):
        scale = np.sqrt(np.diag(sizes))[chosen]
        inner = cross[np.ix_(chosen, chosen)] / np.outer(scale, scale)
        inverse[np.ix_(chosen, chosen)] = np.linalg.pinv(inner, rcond=1e-8) / np.outer(scale, scale)
    values = inverse @ along
    left = [r.target - f @ values for r, f in zip(rows, shown, strict=True)]
    scores = [np.real(np.conj(r.instruments) * e[:, None]) @ inverse.T for r, e in zip(rows, left, strict=True)]
    covariance = _larger(sandwich(np.eye(len(values)), scores), _left_out(rows, shown, values, chosen))
    unidentified = ~identified
    unidentified[chosen] |= _confused([each[:, chosen] for each in shown])
    covariance[unidentified, :] = covariance[:, unidentified] = 0.0
    covariance[unidentified, unidentified] = np.inf
    residual = float(np.sqrt(np.mean(np.abs(np.concatenate(left)) ** 2)))
    return Fit(values, covariance, residual)


def _left_out(rows: Sequence[Rows], shown: Sequence[np.ndarray], values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Variances by the block jackknife: large where a coefficient depends on a few samples."""
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
    if not shown[0].shape[1]:
        return np.zeros(0, bool)
    size = np.sqrt(_power(shown))
    together = sum(np.real(np.conj(each).T @ each) for each in shown) / np.outer(size, size)
    values, directions = np.linalg.eigh(together)
    little = values < values[-1] / CONDITION**2
    return np.asarray(np.any(np.abs(directions[:, little]) > _PART, axis=1))


def _larger(covariance: np.ndarray, variances: np.ndarray) -> np.ndarray:
    own = np.diag(covariance)
    factor = np.sqrt(np.maximum(variances / np.where(own > 0.0, own, np.inf), 1.0))
    return np.asarray(covariance * np.outer(factor, factor))


BLOCKS = 20  # Number of blocks of the jackknife, over all recordings

CONDITION, _PART = 30.0, 0.3
"""Condition index above which regressors count as collinear, the usual one; component above which one is concerned."""

WEAK = 0.1  # Correlation of a regressor with its instrument below which the coefficient is unidentified [-]


def _power(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.asarray(sum(np.sum(np.abs(each) ** 2, axis=0) for each in parts))


class Solution(NamedTuple):
    """Parameters of a linear regression."""

    values: np.ndarray  # in the order of the regressors, (n,)
    deviations: np.ndarray  # standard deviations for white residuals, (n,)
    left: float


def solved(normal: np.ndarray, right: np.ndarray, power: float, count: float, worst: float = 1e8) -> Solution | None:
    """Solution of the normal equations; None if a regressor is zero or they are nearly dependent.

    Args:
        normal: sums of the products of the regressors, (n, n)
        right: sums of the products of regressors and target, (n,)
        worst: largest condition number of the equations, with normalised regressors [-]
    """
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > worst:
        return None
    values = np.linalg.solve(normal, right)
    left = max(float(power - values @ right), 0.0)
    return Solution(values, np.sqrt(left / count * np.diag(np.linalg.inv(normal))), left)
