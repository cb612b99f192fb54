"""Estimates of one quantity from the drives of many cars, and the filter of level and trend over them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError


@dataclass(frozen=True, eq=False)
class Drives:
    """One row per car, its drives in the order of time; NaN fills the rows of cars with fewer drives."""

    day: np.ndarray  # of each drive [d], (cars, drives)
    estimate: np.ndarray  # of the quantity [unit of the quantity], (cars, drives)
    deviation: np.ndarray  # standard deviation that the drive states for its estimate [same unit], (cars, drives)
    # other influences on the estimate (temperature, mileage), each less its reference, in any unit, (cars, drives,
    # regressors); NaN counts as the reference
    regressors: np.ndarray

    def __post_init__(self) -> None:
        shape = self.day.shape
        if len(shape) != 2 or self.estimate.shape != shape or self.deviation.shape != shape:
            raise ParameterError(
                f"day, estimate and deviation have the shapes {shape}, {self.estimate.shape} and "
                f"{self.deviation.shape}; expected one row per car and one column per drive of all three"
            )
        if self.regressors.shape[:-1] != shape:
            raise ParameterError(f"regressors have the shape {self.regressors.shape}; expected (*{shape}, regressors)")

    @property
    def present(self) -> np.ndarray:
        """Whether there is a drive, (cars, drives)."""
        return np.asarray(np.isfinite(self.day) & np.isfinite(self.estimate) & np.isfinite(self.deviation))

    @property
    def effects(self) -> np.ndarray:
        """The regressors, with the reference in place of unknown values, (cars, drives, regressors)."""
        return np.asarray(np.where(np.isfinite(self.regressors), self.regressors, 0.0))

    def of(self, cars: slice | np.ndarray) -> Drives:
        """The table of some of the cars."""
        return Drives(self.day[cars], self.estimate[cars], self.deviation[cars], self.regressors[cars])


def gathered(
    car: np.ndarray, day: np.ndarray, estimate: np.ndarray, deviation: np.ndarray, regressors: np.ndarray
) -> tuple[Drives, np.ndarray]:
    """The table of drives that are given in any order, and the place of every drive in it.

    Args: car: number of the car of each drive, from 0 on, (n,); day, estimate, deviation: (n,) each, see `Drives`; all
    finite; regressors: (n, regressors).

    Returns:
        the table, and for every drive its (row, column), (n, 2)
    """
    order = np.lexsort((day, car))
    cars = int(car.max()) + 1 if len(car) else 0
    counts = np.bincount(car, minlength=cars)
    first = np.concatenate(([0], np.cumsum(counts)[:-1])) if cars else np.zeros(0, int)
    column = np.empty(len(car), int)
    column[order] = np.arange(len(car)) - first[car[order]]
    shape = (cars, int(counts.max(initial=0)))
    table = [np.full(shape, np.nan) for _ in range(3)]
    for whole, values in zip(table, (day, estimate, deviation), strict=True):
        whole[car, column] = values
    moved = np.full((*shape, regressors.shape[1]), np.nan)
    moved[car, column] = regressors
    return Drives(table[0], table[1], table[2], moved), np.stack((car, column), axis=1)


# Distance of two levels [standard deviations of their difference] from which a level has stepped: one of two million
# pairs of equal levels is as far apart. A fleet of a thousand cars with a drive a week gives 50 000 pairs a year.
JUMP = 5.0
# Distance from the level of its side [standard deviations] up to which a drive agrees: all but one of 16 000 do
DISTANT = 4.0
# Difference of the sums of squared normal errors from which a step explains the drives better than a ramp, which has as
# many parameters: a likelihood ratio of 20, that of two levels `JUMP` apart
BEYOND_RAMP = 6.0
# Distance from the level [standard deviations of it] by which the next drive continues the change: a ramp goes on,
# while after a step one of 160 drives is as far
CONTINUES = 2.5
MOST = 3  # Largest number of drives on each side. More would span months, in which a level may change slowly.


class _Table(NamedTuple):
    """Drives with the present ones first, so that neighbours in the table are neighbours in time, (cars, drives)."""

    day: np.ndarray
    value: np.ndarray
    variance: np.ndarray

    def of(self, part: slice) -> _Table:
        return _Table(self.day[:, part], self.value[:, part], self.variance[:, part])


def level_steps(drives: Drives, variance: np.ndarray, effects: np.ndarray, least: float) -> np.ndarray:
    """Drives with which a new level begins, (cars, drives).

    The two or three drives from a step on are compared with the two or three before it; a car that steps after its very
    first drive has only that one. A single drive that is far off is no step: it may be wrong.

    Args: variance: of each drive about the level of its car [unit**2], (cars, drives); least: smallest step [unit];
    smaller ones are followed as slow changes are.
    """
    order = np.argsort(~drives.present, axis=1, kind="stable")
    value = np.where(drives.present, drives.estimate - drives.effects @ effects, np.nan)
    table = _Table(*(np.take_along_axis(each, order, axis=1) for each in (drives.day, value, variance)))
    found = np.zeros(value.shape, bool)
    # One drive before is enough only where there is no other.
    windows = [(1, 1, after) for after in (2, MOST)]
    windows += [
        (first, before, after)
        for first in range(2, value.shape[1])
        for before, after in product((2, MOST), repeat=2)
        if before <= first
    ]
    # NaN of absent drives makes every comparison false.
    with np.errstate(invalid="ignore"):
        for first, before, after in windows:
            if first + after <= value.shape[1]:
                found[:, first] |= _is_step(table, first, before, after, least)
    result = np.zeros(found.shape, bool)
    np.put_along_axis(result, order, found, axis=1)
    return result


def _is_step(table: _Table, first: int, before: int, after: int, least: float) -> np.ndarray:
    """Whether the level of each car steps with a drive, by some drives before and from it on, (cars,)."""
    day, value, variance = table.of(slice(first - before, first + after))
    weight = 1.0 / variance
    side = np.arange(value.shape[1]) >= before
    information = [weight[:, each].sum(axis=1) for each in (~side, side)]
    level = [(weight * value)[:, each].sum(axis=1) / weight[:, each].sum(axis=1) for each in (~side, side)]
    apart = (level[1] - level[0]) / np.sqrt(1.0 / information[0] + 1.0 / information[1])
    rest = (value - np.where(side, level[1][:, None], level[0][:, None])) ** 2 * weight
    found = (np.abs(apart) >= JUMP) & (np.abs(level[1] - level[0]) >= least) & (rest.max(axis=1) <= DISTANT**2)
    found &= _misfit_of_ramp(day, value, weight) - rest.sum(axis=1) >= BEYOND_RAMP
    for beside, own, sign in ((first - before - 1, 0, -1.0), (first + after, 1, 1.0)):
        if 0 <= beside < table.value.shape[1]:
            further = sign * np.sign(apart) * (table.value[:, beside] - level[own])
            found &= ~(further > CONTINUES * np.sqrt(table.variance[:, beside] + 1.0 / information[own]))
    return np.asarray(found)


def _misfit_of_ramp(day: np.ndarray, value: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Sum of squared normal errors of each car's drives about their weighted regression on time, (cars,)."""
    whole = weight.sum(axis=1, keepdims=True)
    time = day - (weight * day).sum(axis=1, keepdims=True) / whole
    centred = value - (weight * value).sum(axis=1, keepdims=True) / whole
    moment = np.maximum((weight * time**2).sum(axis=1, keepdims=True), 1e-12)
    slope = (weight * time * centred).sum(axis=1, keepdims=True) / moment
    return np.asarray((weight * (centred - slope * time) ** 2).sum(axis=1))


LEVEL, SLOPE = 0, 1  # Indices of level and slope in the state; the coefficients of the regressors follow
# Variance of a level after a step, over the square of the step: the new level is that of the drives after it
UNKNOWN = 1e4


@dataclass(frozen=True)
class TrendNoise:
    """Process noise between the drives of a car, and measurement noise of a drive."""

    # random walk of the level [unit/sqrt(d)], by wear, grease and settling without a direction
    level_walk: Annotated[float, "unit of the quantity/d**0.5"]
    # random walk of the slope [unit/d/sqrt(d)]: how fast an ageing may set in or end
    slope_walk: Annotated[float, "unit of the quantity/d**1.5"]
    # standard deviation from drive to drive beside the deviations that the drives state [unit], by road, tyres and load
    scatter: Annotated[float, "unit of the quantity"]
    scale: Annotated[float, ""] = 1.0  # true error of a drive over the deviation that it states [-]
    # bound of the normalised innovation [-]; 2.5 loses 1 % of the information of Gaussian drives, and bounds the
    # influence of an outlier
    clip: Annotated[float, ""] = 2.5

    def __post_init__(self) -> None:
        if min(self.level_walk, self.slope_walk, self.scatter) < 0.0 or not (self.scale > 0.0 and self.clip > 0.0):
            raise ParameterError(f"{self} has a negative deviation, or a scale or clip that is not positive")

    def variance(self, deviation: np.ndarray) -> np.ndarray:
        """Variance of a drive about the level of its car [unit**2], from its stated standard deviation [unit]."""
        return np.asarray((self.scale * deviation) ** 2 + self.scatter**2)


@dataclass(frozen=True, eq=False)
class Prior:
    """Prior of the state before the first drive, common to all cars or one for each."""

    mean: np.ndarray  # level [unit], slope [unit/d] and coefficients, (n,) or (cars, n)
    covariance: np.ndarray  # (n, n) or (cars, n, n)

    def of(self, cars: slice | np.ndarray) -> Prior:
        """Prior of some of the cars, given as a slice, mask or indices."""
        mean = self.mean[cars] if self.mean.ndim == 2 else self.mean
        return Prior(mean, self.covariance[cars] if self.covariance.ndim == 3 else self.covariance)


@dataclass(frozen=True, eq=False)
class Filtered:
    """Filtered estimate after each drive; a car without a further drive keeps its last one."""

    mean: np.ndarray  # mean, covariance: of the state, (cars, drives, n) and (cars, drives, n, n)
    covariance: np.ndarray
    innovation: np.ndarray  # innovation, variance: of each drive, (cars, drives); NaN without a drive
    variance: np.ndarray
    weight: np.ndarray  # of each drive, below 1 where the innovation was clipped, (cars, drives); 0 without a drive
    gain: np.ndarray  # Kalman gain times the weight, (cars, drives, n)
    gap: np.ndarray  # time since the drive before [d], (cars, drives); 0 at the first drive and without a drive
    # variance added to the level before each drive [unit**2], (cars, drives); 0 where its level does not step
    step: np.ndarray


def observed(drives: Drives) -> np.ndarray:
    """Row of the measurement matrix of each drive: 1, 0 and the regressors, (cars, drives, n)."""
    one = np.ones((*drives.day.shape, 1))
    return np.concatenate((one, 0.0 * one, drives.effects), axis=2)


def gaps(drives: Drives) -> np.ndarray:
    """Time since the drive before [d], (cars, drives); 0 at the first drive and without a drive."""
    held = np.maximum.accumulate(np.where(drives.present, drives.day, -np.inf), axis=1)
    before = np.concatenate((np.full((len(held), 1), -np.inf), held[:, :-1]), axis=1)
    return np.where(drives.present & np.isfinite(before), drives.day - np.where(np.isfinite(before), before, 0.0), 0.0)


def moved(mean: np.ndarray, covariance: np.ndarray, gap: np.ndarray, noise: TrendNoise) -> None:
    """Predict states over the time between drives, in place: a constant slope plus random walks of level and slope.

    Source: Y. Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, (6.2.2-13). Args: gap:
    time [d], (cars,).
    """
    mean[:, LEVEL] += gap * mean[:, SLOPE]
    covariance[:, LEVEL, :] += gap[:, None] * covariance[:, SLOPE, :]
    covariance[:, :, LEVEL] += gap[:, None] * covariance[:, :, SLOPE]
    slope = noise.slope_walk**2
    covariance[:, LEVEL, LEVEL] += noise.level_walk**2 * gap + slope * gap**3 / 3.0
    covariance[:, SLOPE, SLOPE] += slope * gap
    cross = 0.5 * slope * gap**2
    covariance[:, LEVEL, SLOPE] += cross
    covariance[:, SLOPE, LEVEL] += cross


def filtered(drives: Drives, prior: Prior, noise: TrendNoise, steps: np.ndarray | None = None) -> Filtered:
    """Level, slope and coefficients of every car after each of its drives.

    An innovation beyond `noise.clip` standard deviations is limited to them, and the reduction of the covariance is
    scaled by the same factor. Source: C. J. Masreliez, R. D. Martin, 1977, doi 10.1109/TAC.1977.1101538.
    """
    cars, count = drives.day.shape
    order = 2 + drives.regressors.shape[2]
    mean = np.broadcast_to(prior.mean, (cars, order)).astype(float).copy()
    covariance = np.broadcast_to(prior.covariance, (cars, order, order)).astype(float).copy()
    rows, present, gap = observed(drives), drives.present, gaps(drives)
    spread = np.where(present, noise.variance(drives.deviation), np.inf)
    found = Filtered(
        np.empty((cars, count, order)),
        np.empty((cars, count, order, order)),
        np.full((cars, count), np.nan),
        np.full((cars, count), np.nan),
        np.zeros((cars, count)),
        np.zeros((cars, count, order)),
        gap,
        np.zeros((cars, count)),
    )
    for k in range(count):
        moved(mean, covariance, gap[:, k], noise)
        row, there = rows[:, k], present[:, k]
        innovation = np.where(there, drives.estimate[:, k] - np.einsum("ci,ci->c", mean, row), 0.0)
        if steps is not None:
            found.step[:, k] = np.where(steps[:, k], UNKNOWN * innovation**2, 0.0)
            covariance[:, LEVEL, LEVEL] += found.step[:, k]
        towards = np.einsum("cij,cj->ci", covariance, row)
        variance = np.einsum("ci,ci->c", towards, row) + spread[:, k]
        weight = 1.0 / np.maximum(1.0, np.abs(innovation) / (noise.clip * np.sqrt(variance)))
        gain = towards * (weight / variance)[:, None]
        mean += gain * innovation[:, None]
        covariance -= gain[:, :, None] * towards[:, None, :]
        found.mean[:, k], found.covariance[:, k], found.gain[:, k] = mean, covariance, gain
        found.innovation[there, k], found.variance[there, k] = innovation[there], variance[there]
        found.weight[:, k] = np.where(there, weight, 0.0)
    return found


def smoothed(found: Filtered, noise: TrendNoise) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of the state at each drive, given all drives of the car.

    Source: H. E. Rauch, F. Tung, C. T. Striebel, 1965, doi 10.2514/3.3166.

    Returns:
        smoothed means and covariances, (cars, drives, n) and (cars, drives, n, n)
    """
    mean, covariance = found.mean.copy(), found.covariance.copy()
    for k in range(mean.shape[1] - 2, -1, -1):
        gap = found.gap[:, k + 1]
        ahead, spread = found.mean[:, k].copy(), found.covariance[:, k].copy()
        moved(ahead, spread, gap, noise)
        spread[:, LEVEL, LEVEL] += found.step[:, k + 1]
        cross = found.covariance[:, k].copy()  # of the state now with the state ahead, P F'
        cross[:, :, LEVEL] += gap[:, None] * cross[:, :, SLOPE]
        back = np.swapaxes(np.linalg.solve(_regular(spread), np.swapaxes(cross, 1, 2)), 1, 2)
        mean[:, k] += np.einsum("cij,cj->ci", back, mean[:, k + 1] - ahead)
        covariance[:, k] += back @ (covariance[:, k + 1] - spread) @ np.swapaxes(back, 1, 2)
    return mean, covariance


def _regular(matrix: np.ndarray) -> np.ndarray:
    order = matrix.shape[-1]
    size = np.einsum("cii->c", matrix) / order
    return np.asarray(matrix + 1e-12 * np.maximum(size, 1e-12)[:, None, None] * np.eye(order))


FIRST = 5  # Number of first drives that are compared with each other; no alarm is raised before a car has as many
# Distance from the median [standard deviations] beyond which a first drive is wrong: one of 16 000 right ones is
FAR = 4.0


def with_right_first(drives: Drives, noise: TrendNoise, effects: np.ndarray) -> Drives:
    """The drives without those of each car's first `FIRST` that are far from the median of these.

    The filter has no earlier drive to compare a first drive with: a wrong one makes all later ones appear changed.
    """
    number = np.cumsum(drives.present, axis=1)
    first = drives.present & (number <= FIRST)
    value = np.where(first, drives.estimate - drives.effects @ effects, np.nan)
    middle = np.nanmedian(value, axis=1)
    # The variance of the median of n normal values is pi / 2 of that of their mean.
    spread = np.sqrt(noise.variance(drives.deviation) * (1.0 + 1.57 / FIRST))
    with np.errstate(invalid="ignore"):
        wrong = first & (np.abs(value - middle[:, None]) > FAR * spread) & (number[:, -1:] >= FIRST)
    return Drives(drives.day, np.where(wrong, np.nan, drives.estimate), drives.deviation, drives.regressors)
