"""The trend of every car: level with band, change points, alarms that count every look, and time left to the limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.fleet.cohorts import Cohorted, cohorted
from tierod.fleet.learning import MILEAGE, Learnt, learnt
from tierod.fleet.series import Series
from tierod.methods.trends.change_evidence import evidence
from tierod.methods.trends.drive_filter import Prior, filtered
from tierod.methods.trends.drive_smoother import smoothed
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.first_drives import FIRST, with_right_first
from tierod.methods.trends.fleet_alarms import alarm_level, log_e_values, selected, stopped
from tierod.methods.trends.time_to_limit import chance_by, time_to_limit

CARS_AT_A_TIME = 2000
"""Keeps the memory of a large fleet within some 200 MB."""

SOON = 90.0
"""Days ahead for which the chance of reaching the limit is stated."""


NEIGHBOURS, FAR = 2, 4.0
"""Drives on each side, and deviations from their median, beyond which a drive is wrong."""


@dataclass(frozen=True)
class Design:
    """Limits on false alarms over the fleet, and the change that is looked for.

    Args:
        vehicle_years: between false alarms of fault-free cars, at least [a]
        discovery_rate: share of wrong cars in the list of changed ones, at most, on average
        horizon: time over which a change is equally likely to begin [d]: the life of a car
        least: change that matters, over the distance from nominal to limit: tyres and seasons move a car by less
    """

    vehicle_years: Annotated[float, "a"] = 10_000.0
    discovery_rate: Annotated[float, ""] = 0.1
    horizon: Annotated[float, "d"] = 5478.75
    least: Annotated[float, ""] = 0.03


@dataclass(frozen=True, eq=False)
class Trends:
    """Trends of one quantity of a fleet, car by car.

    Args:
        series: drives
        learnt: of the fleet
        cohorts: that differ
        level, slope: now, at the reference temperature [unit] and [unit/d], (cars, 2): value, standard deviation
        chance: that the limit is reached within `SOON`, (cars,); NaN without limit
        left: time to the limit [d], (cars, 3): with a chance of 5, 50 and 95 %; infinite beyond ten years
        logarithm: of the evidence for a change in days, now, (cars,)
        log_e: logarithm of the e-value of each car, where it was first sure, else now, (cars,)
        alarmed: day of the first alarm, (cars,); NaN without
        listed: whether the car is in the list of changed ones now, (cars,)
        kind, began, earliest, latest: of the likeliest change: `STEP` or `RAMP`, and days, (cars,)
        size: of it [unit] or [unit/d], (cars, 2): value, standard deviation
    """

    series: Series
    learnt: Learnt
    cohorts: Cohorted
    level: np.ndarray
    slope: np.ndarray
    chance: np.ndarray
    left: np.ndarray
    logarithm: np.ndarray
    log_e: np.ndarray
    alarmed: np.ndarray
    listed: np.ndarray
    kind: np.ndarray
    began: np.ndarray
    earliest: np.ndarray
    latest: np.ndarray
    size: np.ndarray

    def band(self, car: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(days, level, standard deviation) of a car at its drives, in the light of all of them, at the reference."""
        one = slice(car, car + 1)
        drives = self.series.drives.of(one)
        mean, covariance = smoothed(filtered(drives, self.learnt.prior.of(one), self.learnt.noise), self.learnt.noise)
        there = drives.present[0]
        row = _level_row(drives.effects[0, :, MILEAGE])[there]
        level = np.einsum("ki,ki->k", row, mean[0, there])
        variance = np.einsum("ki,kij,kj->k", row, covariance[0, there], row)
        return drives.day[0, there], level, np.sqrt(np.maximum(variance, 0.0))


class _Levels(NamedTuple):
    """Level and slope of cars now: (cars, 2) and (cars, 2, 2)."""

    mean: np.ndarray
    covariance: np.ndarray


class _Change(NamedTuple):
    """The change of each car as `Trends` has it, (cars,) each; sizes (cars, 2)."""

    logarithm: np.ndarray
    log_e: np.ndarray
    alarmed: np.ndarray
    kind: np.ndarray
    began: np.ndarray
    earliest: np.ndarray
    latest: np.ndarray
    size: np.ndarray


def trends(series: Series, design: Design) -> Trends:
    """The trend of every car of a fleet.

    Args:
        series: of one quantity
        design: how often the fleet may be wrong
    """
    known, cars = learnt(series), len(series.vehicles)
    drives = with_right_first(series.drives, known.steady, known.prior.mean[2:])
    first = _Levels(*_joined(drives, known.prior, lambda part, prior: _levels(part, prior, known)))
    found = cohorted(series, first.mean[:, 0], np.sqrt(first.covariance[:, 0, 0]), known)
    if found.cohorts is not None:
        known = known.with_usual(found.cohorts.usual, found.cohorts.between)
    now = _Levels(*_joined(drives, known.prior, lambda part, prior: _levels(part, prior, known)))
    change = _Change(*_joined(drives, known.prior, lambda part, prior: _change(part, prior, known, design, cars)))
    listed = selected(change.log_e, design.discovery_rate)
    for car in np.flatnonzero(listed | np.isfinite(change.alarmed)):
        _refine(change, int(car), drives, known)
    chance, left = _ahead(now, series.limit, known.changes.side)
    deviation = np.sqrt(np.maximum(np.einsum("cii->ci", now.covariance), 0.0))
    return Trends(
        series,
        known,
        found,
        np.stack((now.mean[:, 0], deviation[:, 0]), axis=1),
        np.stack((now.mean[:, 1], deviation[:, 1]), axis=1),
        chance,
        left,
        listed=listed,
        **change._asdict(),
    )


def _joined(drives: Drives, prior: Prior, work: Callable[[Drives, Prior], tuple[np.ndarray, ...]]) -> list[np.ndarray]:
    """Results of some work for all cars, a few thousand at a time."""
    cars = len(drives.day)
    slices = [slice(first, first + CARS_AT_A_TIME) for first in range(0, cars, CARS_AT_A_TIME)]
    parts = [work(drives.of(each), prior.of(each)) for each in slices]
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _level_row(mileage: np.ndarray) -> np.ndarray:
    """Row that takes the level at the reference temperature out of a state, (..., 4)."""
    one = np.ones_like(mileage)
    return np.stack((one, 0.0 * one, 0.0 * one, mileage), axis=-1)


def _levels(drives: Drives, prior: Prior, known: Learnt) -> _Levels:
    """Level now, and slope with what mileage adds to it at the car's own rate."""
    found = filtered(drives, prior, known.noise)
    mean, covariance = found.mean[:, -1], found.covariance[:, -1]
    last = drives.present.shape[1] - 1 - drives.present[:, ::-1].argmax(axis=1)
    line = np.arange(len(last))
    mileage = drives.effects[line, last, MILEAGE]
    span = np.nanmax(drives.day, axis=1) - np.nanmin(drives.day, axis=1)
    rate = np.where(span > 0.0, mileage / np.maximum(span, 1.0), 0.0)
    rows = np.stack((_level_row(mileage), _level_row(rate)), axis=1)
    rows[:, 1, :2] = (0.0, 1.0)
    return _Levels(np.einsum("cri,ci->cr", rows, mean), np.einsum("cri,cij,csj->crs", rows, covariance, rows))


def _change(drives: Drives, prior: Prior, known: Learnt, design: Design, cars: int) -> _Change:
    """Evidence for a change of each car, and the first time that it reached the alarm level.

    What matters is added to the condition of an alarm, which can only make false ones fewer. In the list of changed
    cars a car counts where it would be in it alone, or else as it is now.
    """
    found = evidence(drives, filtered(drives, prior, known.steady), known.changes)
    line, last = np.arange(len(drives.day)), drives.day.shape[1] - 1
    # The changes that are looked for have a third of the distance to the limit.
    matters = known.changes.side * found.shift >= 3.0 * known.changes.step * design.least
    ready = matters & (np.cumsum(drives.present, axis=1) >= FIRST)
    reached = ready & (found.logarithm >= alarm_level(design.vehicle_years))
    relevant = np.where(ready, found.logarithm, -np.inf)
    sure = stopped(relevant, math.log(cars / design.discovery_rate * design.horizon))
    days = np.maximum.accumulate(np.where(drives.present, drives.day, -np.inf), axis=1)
    watched = np.maximum(days[line, sure] - np.nanmin(drives.day, axis=1), 0.0)
    alarmed = np.where(reached.any(axis=1), drives.day[line, reached.argmax(axis=1)], np.nan)

    def day_of(drive: np.ndarray, before: bool) -> np.ndarray:
        # A change that acts from a drive on began after the drive before it.
        return np.asarray(drives.day[line, np.maximum(drive - 1, 0) if before else drive])

    return _Change(
        found.logarithm[:, last],
        log_e_values(relevant[line, sure], watched, design.horizon),
        alarmed,
        found.kind[:, last],
        day_of(found.began[:, last], before=True),
        day_of(found.earliest[:, last], before=True),
        day_of(found.latest[:, last], before=False),
        np.stack((found.size[:, last], found.size_deviation[:, last]), axis=1),
    )


def _refine(change: _Change, car: int, drives: Drives, known: Learnt) -> None:
    """Beginning and size of a car's change, anew from all its drives, in place.

    The search that counts every look bounds a drive's evidence, and drops old beginnings. Once a change is found,
    all drives that fit their neighbours count in full.
    """
    one = drives.of(slice(car, car + 1))
    prior = known.prior.of(slice(car, car + 1))
    clean = Drives(one.day, np.where(_alone(one, known), np.nan, one.estimate), one.deviation, one.regressors)
    count = one.day.shape[1]
    steady, changes = replace(known.steady, clip=np.inf), replace(known.changes, beginnings=count)
    found = evidence(clean, filtered(clean, prior, steady), changes)
    place, days = int(np.flatnonzero(clean.present[0])[-1]), one.day[0]
    change.kind[car] = found.kind[0, place]
    change.began[car] = days[max(found.began[0, place] - 1, 0)]
    change.earliest[car] = days[max(found.earliest[0, place] - 1, 0)]
    change.latest[car] = days[found.latest[0, place]]
    change.size[car] = found.size[0, place], found.size_deviation[0, place]


def _alone(one: Drives, known: Learnt) -> np.ndarray:
    """Drives of one car far from the median of their neighbours, (1, drives); a step of the level is no such drive."""
    there = np.flatnonzero(one.present[0])
    value = one.estimate[0, there] - one.effects[0, there] @ known.prior.mean[..., 2:].reshape(-1, 2)[0]
    padded = np.concatenate((value[NEIGHBOURS:0:-1], value, value[-2 : -NEIGHBOURS - 2 : -1]))
    alone = np.zeros(one.day.shape, bool)
    if len(value) > NEIGHBOURS:
        middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1), axis=1)
        spread = np.sqrt(known.steady.variance(one.deviation[0, there]))
        alone[0, there] = np.abs(value - middle) > FAR * spread
    return alone


def _ahead(now: _Levels, limit: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Chance to reach the limit soon, and the time to it; NaN and infinity for cars without a limit."""
    known = np.isfinite(limit)
    # A limit below the level is one above the mirrored level.
    mean, bound = side * now.mean, side * np.where(known, limit, 0.0)
    chance = chance_by(mean, now.covariance, bound, np.full(len(bound), SOON))
    left = [time_to_limit(mean, now.covariance, bound, share) for share in (0.05, 0.5, 0.95)]
    return np.where(known, chance, np.nan), np.where(known[:, None], np.stack(left, axis=1), np.inf)
