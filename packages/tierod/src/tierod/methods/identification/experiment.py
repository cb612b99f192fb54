"""Data of an identification: experiments, free parameters, estimates, and the quality of a fit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from tierod.core.errors import ParameterError, nearest
from tierod.models.linear import describe

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

P = TypeVar("P", bound="DataclassInstance")  # Parameters of a model, a dataclass

INTERVAL = 1.959964  # Half width of the 95 % interval of a normal distribution [standard deviations]
UNKNOWN_BEFORE: tuple[float, float | None] = (math.nan, None)
"""Value and standard deviation of a parameter that is not in the vehicle file."""


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
        """Coordinate of a value in the search.

        Raises:
            ParameterError: a start that is not positive, where the parameter has to be
        """
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
        """Index of a parameter.

        Raises:
            ParameterError: a parameter that was not free
        """
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


UNKNOWN = 0.25
"""Relative standard deviation above which a parameter counts as unidentified [-]; with half of it the ends of the 95 %
interval differ by a factor of about two."""


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

    Args:
        names: of the parameters of interest; all others are treated as unknown
        unknown: relative standard deviation above which a direction counts as unidentified
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
