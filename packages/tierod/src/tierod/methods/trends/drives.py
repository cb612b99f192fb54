"""Table of the estimates of one quantity from the drives of many cars, without outliers at its start, and its steps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

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

    Args:
        car: number of the car of each drive, from 0 on, (n,)
        day, estimate, deviation: (n,) each, see `Drives`; all finite
        regressors: (n, regressors)

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


JUMP = 5.0
"""Distance of two levels [standard deviations of their difference] from which a level has stepped: one of two million
pairs of equal levels is as far apart. A fleet of a thousand cars with a drive a week gives 50 000 pairs a year."""

FAR = 4.0
"""Distance from the level of its side [standard deviations] up to which a drive agrees: all but one of 16 000 do."""

BEYOND_RAMP = 6.0
"""Difference of the sums of squared normal errors from which a step explains the drives better than a ramp, which has
as many parameters: a likelihood ratio of 20, that of two levels `JUMP` apart."""

CONTINUES = 2.5
"""Distance from the level [standard deviations of it] by which the next drive continues the change: a ramp goes on,
while after a step one of 160 drives is as far."""

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

    Args:
        variance: of each drive about the level of its car [unit**2], (cars, drives)
        effects: of the regressors on the estimate, (regressors,)
        least: smallest step [unit]; smaller ones are followed as slow changes are

    The two or three drives from a step on are compared with the two or three before it; a car that steps after its very
    first drive has only that one. A single drive that is far off is no step: it may be wrong.
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
    found = (np.abs(apart) >= JUMP) & (np.abs(level[1] - level[0]) >= least) & (rest.max(axis=1) <= FAR**2)
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
