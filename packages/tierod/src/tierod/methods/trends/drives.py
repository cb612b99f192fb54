"""Table of the estimates of one quantity from the drives of many cars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.core.errors import ParameterError


@dataclass(frozen=True, eq=False)
class Drives:
    """One row per car, its drives in the order of time; NaN fills the rows of cars with fewer drives.

    Args:
        day: of each drive [d], (cars, drives)
        estimate: of the quantity [unit of the quantity], (cars, drives)
        deviation: standard deviation that the drive states for its estimate [same unit], (cars, drives)
        regressors: other influences on the estimate (temperature, mileage), each less its reference, in any unit,
            (cars, drives, regressors); NaN counts as the reference
    """

    day: np.ndarray
    estimate: np.ndarray
    deviation: np.ndarray
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
