"""Data of an identification, quality of a fit, and regressions with robust covariance."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from tierod.core.errors import InputError, ParameterError, nearest
from tierod.models.linear import describe

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


P = TypeVar("P", bound="DataclassInstance")  # Parameters of a model, a dataclass
INTERVAL = 1.959964  # Half width of the 95 % interval of a normal distribution [standard deviations]
# Value and standard deviation of a parameter that is not in the vehicle file
UNKNOWN_BEFORE: tuple[float, float | None] = (math.nan, None)


@dataclass(frozen=True, eq=False)
class Experiment:
    """One recording of a plant, on a uniform grid."""

    name: str
    inputs: np.ndarray  # of the model, shape (n, inputs), without gaps
    measured: np.ndarray  # outputs of the model, shape (n, outputs); NaN where missing
    initial_mean: tuple[float, ...]
    initial_variance: tuple[float, ...]
    # parameters of the model that are specific to this experiment, by name
    setting: Mapping[str, float] = field(default_factory=dict)

    @property
    def samples(self) -> np.ndarray:
        """Inputs and outputs as columns of one array, the sample of a filter, (n, inputs + outputs)."""
        return np.column_stack([self.inputs, self.measured])


@dataclass(frozen=True)
class Free:
    """A parameter to be identified."""

    name: str
    # whether it must be positive: then its logarithm is the coordinate of the search, and `spread` relative
    positive: bool = True
    # prior standard deviation about the start, in the coordinate of the search; None without a prior
    spread: float | None = None

    def coordinate(self, value: float) -> float:
        if self.positive and not value > 0.0:
            raise ParameterError(f"the search for {self.name} cannot start at {value:g}; give a value above zero")
        return math.log(value) if self.positive else value

    def value(self, coordinate: float) -> float:
        return math.exp(coordinate) if self.positive else coordinate

    def slope(self, value: float) -> float:
        """Derivative of the value with respect to the coordinate."""
        return value if self.positive else 1.0


def with_values(parameters: P, free: Sequence[Free], place: np.ndarray, setting: Mapping[str, float]) -> P:
    """Parameters of a model at a place (vector of coordinates) of the search, with the setting of an experiment."""
    found = {each.name: each.value(float(x)) for each, x in zip(free, place, strict=True)}
    return replace(parameters, **setting, **found)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of an identification."""

    free: tuple[Free, ...]
    start: tuple[float, ...]  # start, values: before and after
    values: tuple[float, ...]
    covariance: np.ndarray  # of the coordinates of the search, also valid for autocorrelated residuals
    information: np.ndarray  # second derivatives of the cost, with the prior
    cost: float  # half the sum of squares, or the negative log-likelihood
    residuals: tuple[np.ndarray, ...]  # standardised, of every experiment, shape (n, outputs); NaN where missing
    # input_deviation, output_deviation: estimated or assumed standard deviations of the noise; empty for none
    input_deviation: tuple[float, ...] = ()
    output_deviation: tuple[float, ...] = ()
    steps: int = 0
    converged: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(each.name for each in self.free)

    def index(self, name: str) -> int:
        """Index of a parameter."""
        if name not in self.names:
            raise ParameterError(f"'{name}' was not identified{nearest(name, self.names)}")
        return self.names.index(name)

    def __getitem__(self, name: str) -> float:
        return self.values[self.index(name)]

    def deviation(self, name: str) -> float:
        """Standard deviation of a parameter, in its unit."""
        k = self.index(name)
        return abs(self.free[k].slope(self.values[k])) * math.sqrt(max(self.covariance[k, k], 0.0))

    def interval(self, name: str) -> tuple[float, float]:
        """95 % confidence interval of a parameter, for an exact model."""
        k = self.index(name)
        centre, half = self.free[k].coordinate(self.values[k]), INTERVAL * math.sqrt(max(self.covariance[k, k], 0.0))
        return self.free[k].value(centre - half), self.free[k].value(centre + half)

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix of the coordinates of the search."""
        spread = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(spread, spread))

    def parameters(self, base: P, setting: Mapping[str, float] | None = None) -> P:
        """The model's parameters with the identified values and an experiment's setting."""
        return replace(base, **dict(setting or {}), **dict(zip(self.names, self.values, strict=True)))


@dataclass(frozen=True)
class Found:
    """A parameter before and after identification."""

    name: str
    # before, before_deviation: value and standard deviation in the vehicle file; NaN and None where it has none
    before: float
    before_deviation: float | None
    value: float
    deviation: float
    low: float  # low, high: ends of the 95 % interval
    high: float
    method: str  # name of the method, such as "instruments", "likelihood" or "drives"

    @classmethod
    def normal(
        cls, name: str, before: tuple[float, float | None], value: float, deviation: float, method: str
    ) -> Found:
        """Result with the interval of a normal distribution; `before` is value and deviation in the vehicle file."""
        half = INTERVAL * deviation
        return cls(name, *before, value, deviation, value - half, value + half, method)

    @property
    def change(self) -> float:
        """Relative change of the value; NaN where it was zero before."""
        return self.value / self.before - 1.0 if self.before else math.nan


LAGS = 25  # Number of lags of the autocorrelation of residuals


class Whiteness(NamedTuple):
    """Autocorrelation of residuals."""

    largest: float  # in magnitude, of lags 1 to 25, with its sign
    outside: float  # share of these lags outside the 95 % band of white noise; 0.05 for white residuals


def normalised_error(simulated: np.ndarray, measured: np.ndarray) -> float:
    """Root mean square error over the standard deviation of the measured signal [-]; NaN where that is constant."""
    known = np.isfinite(measured)
    spread = float(np.std(measured[known]))
    if not spread > 0.0:
        return float("nan")
    return float(np.sqrt(np.mean((simulated[known] - measured[known]) ** 2))) / spread


def whiteness(residuals: Sequence[np.ndarray]) -> Whiteness:
    """Whiteness of the residuals of one output in several experiments, each (n,); missing ones are left out."""
    power = sum(float(np.nansum(each**2)) for each in residuals)
    count = sum(int(np.isfinite(each).sum()) for each in residuals)
    if not power > 0.0:
        return Whiteness(0.0, 0.0)
    found = [sum(float(np.nansum(e[lag:] * e[:-lag])) for e in residuals) / power for lag in range(1, LAGS + 1)]
    bound = INTERVAL / np.sqrt(count)
    return Whiteness(float(max(found, key=abs)), float(np.mean(np.abs(found) > bound)))


# Relative standard deviation above which a parameter counts as unidentified [-]; with half of it the ends of the 95 %
# interval differ by a factor of about two
UNKNOWN = 0.25


class Blind(NamedTuple):
    """A direction of the free parameters that the experiments do not identify."""

    deviation: float
    direction: str  # as text: "0.71 motor_friction - 0.7 motor_damping"
    names: tuple[str, ...]


def profiled(information: np.ndarray, count: int) -> np.ndarray:
    """Information on the first coordinates with all others unknown (Schur complement)."""
    own, cross, rest = information[:count, :count], information[:count, count:], information[count:, count:]
    return own - cross @ np.linalg.pinv(rest, hermitian=True) @ cross.T if len(rest) else own


def blind_directions(estimate: Estimate, names: Sequence[str], unknown: float = UNKNOWN) -> list[Blind]:
    """Unidentified directions of the parameters, the worst first.

    All named parameters have to be positive, so that the coordinates of the search are logarithms and standard
    deviations are relative.

    Args: names: of the parameters of interest; all others are treated as unknown.
    """
    order = [estimate.index(name) for name in names]
    rest = [k for k in range(len(estimate.information)) if k not in order]
    whole = [*order, *rest]
    values, directions = np.linalg.eigh(profiled(estimate.information[np.ix_(whole, whole)], len(order)))
    found = []
    for value, direction in zip(values, directions.T, strict=True):
        deviation = 1.0 / np.sqrt(max(value, 1e-12))
        if deviation > unknown:
            parts = [k for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > 0.3]
            found.append(Blind(float(deviation), describe(direction, tuple(names)), tuple(names[k] for k in parts)))
    return found


def refusal(blind: Sequence[Blind], experiments: Sequence[str], cures: Mapping[str, str]) -> str:
    """Message on parameters that the experiments do not excite, and on what to record instead."""
    worst = blind[0]
    which = "this recording does" if len(experiments) == 1 else "these recordings do"
    what = worst.names[0] if len(worst.names) == 1 else f"{', '.join(worst.names[:-1])} and {worst.names[-1]} apart"
    spread = "not at all" if worst.deviation > 10.0 else f"only within {100.0 * worst.deviation:.0f} %"
    cure = "; ".join(dict.fromkeys(cures[name] for name in worst.names if name in cures))
    return (
        f"{which} not excite {what} ({', '.join(experiments)}): the direction {worst.direction} is identified "
        f"{spread}; record {cure or 'a test that excites them'} instead, or leave it out of --free"
    )


@dataclass(frozen=True)
class Modulation:
    """Weighted means over a sliding window; by partial integration, derivatives act on the weight, which is known.

    The weight is sin^4: it and its first three derivatives are zero at the ends, so that no boundary terms remain. Rows
    whose window contains a missing sample are NaN.

    Source: M. Shinbrot, Trans. ASME 79 (1957) 547.
    """

    length: int
    stride: int
    step: float  # sampling interval [s]

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

    Source: W. K. Newey, K. D. West, Econometrica 55 (1987) 703; D. W. K. Andrews, Econometrica 59 (1991) 817, eq (6.4).
    Args: scores: derivative of the cost of every sample by the parameters, one array (n, parameters) per experiment.
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

    Source: T. Soderstrom, P. Stoica, Instrumental Variable Methods for System Identification (1983), chapter 4. Args:
    target: one array (n,) per experiment; regressors: one array (n, coefficients) per experiment; noisy; instruments:
    one array of the same shape per experiment; correlated with the regressors, with independent noise.
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
# Condition index above which regressors count as collinear, the usual one; component above which one is concerned
CONDITION, _PART = 30.0, 0.3
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

    Args: normal: sums of the products of the regressors, (n, n); right: sums of the products of regressors and target,
    (n,); worst: largest condition number of the equations, with normalised regressors [-].
    """
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > worst:
        return None
    values = np.linalg.solve(normal, right)
    left = max(float(power - values @ right), 0.0)
    return Solution(values, np.sqrt(left / count * np.diag(np.linalg.inv(normal))), left)
