"""Kalman filter and smoother over drives: level and slope of a quantity, with regressors, for many cars in parallel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.trends.drives import Drives

LEVEL, SLOPE = 0, 1  # Indices of level and slope in the state; the coefficients of the regressors follow

UNKNOWN = 1e4
"""Variance of a level after a step, over the square of the step: the new level is that of the drives after it."""


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

    Args:
        mean, covariance: of the state, (cars, n) and (cars, n, n)
        gap: time [d], (cars,)

    Source: Y. Bar-Shalom et al., Estimation with Applications to Tracking and Navigation, 2001, (6.2.2-13).
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

    Args:
        steps: drives with which a new level begins, about which the earlier drives say nothing, (cars, drives)

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

    Args:
        noise: of the walks, the same as in the filter

    Returns:
        smoothed means and covariances, (cars, drives, n) and (cars, drives, n, n)

    Source: H. E. Rauch, F. Tung, C. T. Striebel, 1965, doi 10.2514/3.3166.
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
    """The covariance with a small diagonal added: a coefficient without uncertainty would make it singular."""
    order = matrix.shape[-1]
    size = np.einsum("cii->c", matrix) / order
    return np.asarray(matrix + 1e-12 * np.maximum(size, 1e-12)[:, None, None] * np.eye(order))


FIRST = 5  # Number of first drives that are compared with each other; no alarm is raised before a car has as many

FAR = 4.0
"""Distance from the median [standard deviations] beyond which a first drive is wrong: one of 16 000 right ones is."""


def with_right_first(drives: Drives, noise: TrendNoise, effects: np.ndarray) -> Drives:
    """The drives without those of each car's first `FIRST` that are far from the median of these.

    The filter has no earlier drive to compare a first drive with: a wrong one makes all later ones appear changed.

    Args:
        effects: of the regressors on the estimate, (regressors,)
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
