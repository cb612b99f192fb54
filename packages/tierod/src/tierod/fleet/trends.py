"""Trend of every car: level with band, change detection with bounded false alarms, and time left until the limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.fleet.series import Series
from tierod.fleet.statistics import MILEAGE, Cohorted, Learnt, cohorted, learnt
from tierod.methods.trends.change_evidence import (
    alarm_level,
    chance_by,
    evidence,
    log_e_values,
    selected,
    stopped,
    time_to_limit,
)
from tierod.methods.trends.drive_filter import (
    FIRST,
    JUMP,
    Drives,
    Prior,
    filtered,
    level_steps,
    smoothed,
    with_right_first,
)

CARS_AT_A_TIME = 2000  # Number of cars filtered at once; limits the memory for a large fleet to some 200 MB

SOON = 90.0  # Horizon for which the probability of reaching the limit is stated [d]


NEIGHBOURS, FAR = 2, 4.0
"""Number of drives on each side, and distance from their median in standard deviations beyond which a drive is an
outlier.
"""

LEAST_STEP = 0.1
"""Smallest step of a level, relative to the distance from nominal to limit: the filter follows a smaller one in time,
and a ramp that takes a year to the limit is never taken for one."""


@dataclass(frozen=True)
class Design:
    """Permitted false alarms of the fleet, and the smallest relevant change."""

    vehicle_years: Annotated[float, "a"] = 10_000.0  # smallest mean time between false alarms of fault-free cars [a]
    # largest false-discovery rate: expected share of unchanged cars in the list of changed cars
    discovery_rate: Annotated[float, ""] = 0.1
    # time over which the onset of a change is uniformly distributed [d]: the life of a car
    horizon: Annotated[float, "d"] = 5478.75
    # smallest relevant change relative to the distance from nominal to limit: tyres and seasons cause less
    least: Annotated[float, ""] = 0.03


@dataclass(frozen=True, eq=False)
class Trends:
    """Trends of one quantity of a fleet, car by car."""

    series: Series
    learnt: Learnt
    cohorts: Cohorted
    # drives with which a new level begins, the first one included if another is early, (cars, drives)
    steps: np.ndarray
    before: np.ndarray  # level before the last step [unit], (cars,); NaN without one
    # last estimate of each car where it is far from the level, and no part of it until another drive agrees [unit],
    # (cars,); NaN where there is none
    unconfirmed: np.ndarray
    # level, slope: current values at the reference temperature [unit] and [unit/d], (cars, 2): value, standard
    # deviation
    level: np.ndarray
    slope: np.ndarray
    chance: np.ndarray  # probability that the limit is reached within `SOON`, (cars,); NaN without limit
    # time until the limit [d], (cars, 3): quantiles of 5, 50 and 95 %; infinite beyond ten years, zero where the level
    # has reached it, NaN where too few drives have followed a step or a last drive far off
    left: np.ndarray
    logarithm: np.ndarray  # current logarithm of the evidence for a change [evidence in d], (cars,)
    # logarithm of each car's e-value when it first reached the level of the list, else the current one, (cars,)
    log_e: np.ndarray
    alarmed: np.ndarray  # day of the first alarm, (cars,); NaN without alarm
    listed: np.ndarray  # whether the car is in the current list of changed cars, (cars,)
    # kind, began, earliest, latest: likeliest change: `STEP` or `RAMP`, and onset with its interval [d], (cars,)
    kind: np.ndarray
    began: np.ndarray
    earliest: np.ndarray
    latest: np.ndarray
    size: np.ndarray  # its magnitude [unit] or [unit/d], (cars, 2): value, standard deviation

    def stated(self, car: int) -> tuple[float, float]:
        """Current level of a car and its standard deviation, with the part that all its drives share [unit]."""
        value, deviation = self.level[car]
        return float(value), math.hypot(float(deviation), float(self.series.shared[car]))

    def band(self, car: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(days, smoothed level at the reference temperature, standard deviation) of a car at its drives.

        At a step of the level there are two rows with the day of the drive: the level before, and the new one.
        """
        one = slice(car, car + 1)
        drives = self.series.drives.of(one)
        if math.isfinite(self.unconfirmed[car]):
            drives = _without_last(drives)
        noise, steps = self.learnt.noise, self.steps[one]
        mean, covariance = smoothed(filtered(drives, self.learnt.prior.of(one), noise, steps), noise)
        there = drives.present[0]
        row = _level_row(drives.effects[0, :, MILEAGE])[there]
        level = np.einsum("ki,ki->k", row, mean[0, there])
        variance = np.einsum("ki,kij,kj->k", row, covariance[0, there], row)
        day, deviation = drives.day[0, there], np.sqrt(np.maximum(variance, 0.0))
        at = np.flatnonzero(steps[0, there][1:]) + 1
        before, spread = (np.insert(each, at, each[at - 1]) for each in (level, deviation))
        return np.insert(day, at, day[at]), before, spread

    @property
    def reached(self) -> np.ndarray:
        """Whether the level of each car is at its limit or beyond, (cars,)."""
        side = self.learnt.changes.side
        with np.errstate(invalid="ignore"):
            return np.asarray(side * self.level[:, 0] >= side * self.series.limit)

    def stepped(self, car: int) -> float:
        """Day of the first drive at the present level of a car [d]; NaN if its level never stepped."""
        steps = np.flatnonzero(self.steps[car])
        return float(self.series.drives.day[car, steps[-1]]) if len(steps) else math.nan

    def ended(self, car: int) -> bool:
        """Whether the level of a car has stepped back to that before its change."""
        if not self.stepped(car) > self.began[car]:
            return False
        day, level, _ = self.band(car)
        before = level[max(int(np.searchsorted(day, self.began[car], side="right")) - 1, 0)]
        return bool(self.learnt.changes.side * (self.level[car, 0] - before) < _least_step(self.learnt))

    def changed(self, car: int) -> bool:
        """Whether a change of a car was found that has not ended."""
        return bool(self.listed[car] or math.isfinite(self.alarmed[car])) and not self.ended(car)

    def onset(self, car: int) -> float:
        """Day on which the change of a car began [d]: that of its step, where the level stepped at that time."""
        stepped = self.stepped(car)
        return stepped if self.earliest[car] <= stepped <= self.latest[car] else float(self.began[car])

    @property
    def held(self) -> np.ndarray:
        """Number of drives of each car at its present level, (cars,)."""
        present = self.series.drives.present
        since = np.cumsum(self.steps[:, ::-1], axis=1)[:, ::-1] - self.steps == 0
        return np.asarray((present & since).sum(axis=1))


class _Levels(NamedTuple):
    """Current level and slope of the cars with covariance, level before the last step, and a last drive far off."""

    mean: np.ndarray
    covariance: np.ndarray
    before: np.ndarray
    unconfirmed: np.ndarray


class _Change(NamedTuple):
    """Likeliest change of each car, with the fields of `Trends`, (cars,) each; sizes (cars, 2)."""

    logarithm: np.ndarray
    log_e: np.ndarray
    alarmed: np.ndarray
    kind: np.ndarray
    began: np.ndarray
    earliest: np.ndarray
    latest: np.ndarray
    size: np.ndarray


def trends(series: Series, design: Design) -> Trends:
    """Estimate the trend of every car of a fleet."""
    known, cars = learnt(series), len(series.vehicles)
    drives = with_right_first(series.drives, known.steady, known.prior.mean[2:])
    stepping, steps = _stepping(series.drives, drives, known)

    def levels(chosen: slice, _: Drives, prior: Prior) -> tuple[np.ndarray, ...]:
        return _levels(stepping.of(chosen), prior, known, steps[chosen])

    first = _Levels(*_joined(drives, known.prior, levels))
    usual = first.mean[:, 0]
    # A car that stepped is compared with its cohort by that of both levels which is the more usual one.
    with np.errstate(invalid="ignore"):
        nearer = np.abs(first.before - known.prior.mean[0]) < np.abs(usual - known.prior.mean[0])
    found = cohorted(series, np.where(nearer, first.before, usual), np.sqrt(first.covariance[:, 0, 0]), known)
    if found.cohorts is not None:
        known = known.with_usual(found.cohorts.usual, found.cohorts.between)
    # The levels again, now with the cohorts in the prior of each car.
    now = _Levels(*_joined(drives, known.prior, levels))
    change = _Change(*_joined(drives, known.prior, lambda _, part, prior: _change(part, prior, known, design, cars)))
    listed = selected(change.log_e, design.discovery_rate)
    for car in np.flatnonzero(listed | np.isfinite(change.alarmed)):
        _refine(change, int(car), drives, known)
    chance, left = _ahead(now, series.limit, known.changes.side)
    deviation = np.sqrt(np.maximum(np.einsum("cii->ci", now.covariance), 0.0))
    made = Trends(
        series,
        known,
        found,
        steps,
        now.before,
        now.unconfirmed,
        np.stack((now.mean[:, 0], deviation[:, 0]), axis=1),
        np.stack((now.mean[:, 1], deviation[:, 1]), axis=1),
        chance,
        left,
        listed=listed,
        **change._asdict(),
    )
    # No trend leads across a step; after a first drive far off there may be one.
    few = (steps.any(axis=1) & (made.held < FIRST)) | np.isfinite(now.unconfirmed)
    left[few & np.isfinite(series.limit)] = np.nan
    left[made.reached] = 0.0
    return made


def _stepping(every: Drives, right: Drives, known: Learnt) -> tuple[Drives, np.ndarray]:
    """Drives from which levels are estimated, and with which of them a new level begins.

    Of a car whose level steps within its first drives none of these is wrong for being far from the others, and its
    first level is not that of the usual car: it begins with a step as well. The last drive may be the first of a step.
    """
    first = np.cumsum(every.present, axis=1)

    def steps(drives: Drives) -> np.ndarray:
        variance = known.steady.variance(drives.deviation)
        return level_steps(drives, variance, known.prior.mean[2:], _least_step(known))

    early = np.asarray((steps(every) & (first <= FIRST)).any(axis=1))
    kept = early[:, None] | (np.arange(first.shape[1]) == _last(every)[:, None])
    estimate = np.where(kept, every.estimate, right.estimate)
    found = Drives(every.day, estimate, every.deviation, every.regressors)
    return found, steps(found) | (early[:, None] & every.present & (first == 1))


def _least_step(known: Learnt) -> float:
    # The step of `known.changes` is a third of the distance to the limit.
    return 3.0 * known.changes.step * LEAST_STEP


def _last(drives: Drives) -> np.ndarray:
    return np.asarray(drives.present.shape[1] - 1 - drives.present[:, ::-1].argmax(axis=1))


def _without_last(drives: Drives, cars: np.ndarray | None = None) -> Drives:
    """The drives without the last one of some cars, given as a mask; of all if not given."""
    estimate, chosen = drives.estimate.copy(), np.arange(len(drives.day)) if cars is None else np.flatnonzero(cars)
    estimate[chosen, _last(drives)[chosen]] = np.nan
    return Drives(drives.day, estimate, drives.deviation, drives.regressors)


def _joined(
    drives: Drives, prior: Prior, work: Callable[[slice, Drives, Prior], tuple[np.ndarray, ...]]
) -> list[np.ndarray]:
    """Results of a function of some cars, their drives and priors, for all cars, a few thousand at a time."""
    cars = len(drives.day)
    slices = [slice(first, first + CARS_AT_A_TIME) for first in range(0, cars, CARS_AT_A_TIME)]
    parts = [work(each, drives.of(each), prior.of(each)) for each in slices]
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _level_row(mileage: np.ndarray) -> np.ndarray:
    one = np.ones_like(mileage)
    return np.stack((one, 0.0 * one, 0.0 * one, mileage), axis=-1)


def _levels(drives: Drives, prior: Prior, known: Learnt, steps: np.ndarray) -> _Levels:
    """Current level, and slope including the effect of mileage at the car's own rate of mileage."""
    found, last = filtered(drives, prior, known.noise, steps), _last(drives)
    line, innovation = np.arange(len(last)), found.innovation
    off = np.abs(innovation[line, last])
    far = (off > JUMP * np.sqrt(found.variance[line, last])) & (off > _least_step(known)) & ~steps[line, last]
    far &= drives.present.sum(axis=1) > 1
    unconfirmed = np.where(far, drives.estimate[line, last], np.nan)
    if far.any():
        drives = _without_last(drives, far)
        found, last = filtered(drives, prior, known.noise, steps), _last(drives)
    mean, covariance = found.mean[:, -1], found.covariance[:, -1]
    mileage = drives.effects[line, last, MILEAGE]
    span = np.nanmax(drives.day, axis=1) - np.nanmin(drives.day, axis=1)
    rate = np.where(span > 0.0, mileage / np.maximum(span, 1.0), 0.0)
    rows = np.stack((_level_row(mileage), _level_row(rate)), axis=1)
    rows[:, 1, :2] = (0.0, 1.0)
    stepped = steps.shape[1] - 1 - steps[:, ::-1].argmax(axis=1)
    before = np.einsum("ci,ci->c", rows[:, 0], found.mean[line, stepped - 1])
    return _Levels(
        np.einsum("cri,ci->cr", rows, mean),
        np.einsum("cri,cij,csj->crs", rows, covariance, rows),
        np.where(steps.any(axis=1), before, np.nan),
        unconfirmed,
    )


def _change(drives: Drives, prior: Prior, known: Learnt, design: Design, cars: int) -> _Change:
    """Evidence for a change of each car, and the first day on which it reached the alarm level.

    An alarm also requires a relevant change, which can only reduce false alarms. The e-value of a car is taken when it
    first would be on the list by itself, else now.
    """
    found = evidence(drives, filtered(drives, prior, known.steady), known.changes)
    line, last = np.arange(len(drives.day)), drives.day.shape[1] - 1
    # The step of `known.changes` is a third of the distance to the limit.
    matters = known.changes.side * found.shift >= 3.0 * known.changes.step * design.least
    ready = matters & (np.cumsum(drives.present, axis=1) >= FIRST)
    reached = ready & (found.logarithm >= alarm_level(design.vehicle_years))
    relevant = np.where(ready, found.logarithm, -np.inf)
    sure = stopped(relevant, math.log(cars / design.discovery_rate * design.horizon))
    days = np.maximum.accumulate(np.where(drives.present, drives.day, -np.inf), axis=1)
    watched = np.maximum(days[line, sure] - np.nanmin(drives.day, axis=1), 0.0)
    alarmed = np.where(reached.any(axis=1), drives.day[line, reached.argmax(axis=1)], np.nan)

    def day_of(drive: np.ndarray, before: bool) -> np.ndarray:
        # A change that acts from a drive on began after the previous drive.
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
    """Re-estimate onset and magnitude of a car's change from all its drives, in place.

    The sequential detection clips the evidence of a drive, and discards old onsets. Once a change is detected, all
    drives that agree with their neighbours count in full.
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
    """Outlier drives of one car, far from the median of their neighbours, (1, drives); a step of the level is none."""
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
    """Probability of reaching the limit soon, and time until the limit; NaN and infinity for cars without a limit."""
    known = np.isfinite(limit)
    # A limit below the level is handled as one above the mirrored level.
    mean, bound = side * now.mean, side * np.where(known, limit, 0.0)
    chance = chance_by(mean, now.covariance, bound, np.full(len(bound), SOON))
    left = [time_to_limit(mean, now.covariance, bound, share) for share in (0.05, 0.5, 0.95)]
    return np.where(known, chance, np.nan), np.where(known[:, None], np.stack(left, axis=1), np.inf)
