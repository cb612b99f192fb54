"""Evidence for a change of a car's level, and alarms of a fleet with a bound on false ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.errors import ParameterError
from tierod.methods.trends.drive_filter import LEVEL, SLOPE, Drives, Filtered, observed
from tierod.methods.trends.drive_scatter import EVERY, WRONG

STEP, RAMP = 0, 1  # Kinds of change: a step of the level, and a ramp that starts a constant slope


@dataclass(frozen=True)
class Changes:
    """Prior of the changes to be detected, and of shifts and outliers of fault-free cars."""

    # standard deviation of the sizes of steps [unit]; the size of a step worth finding
    step: Annotated[float, "unit of the quantity"]
    ramp: Annotated[float, "unit of the quantity/d"]  # standard deviation of the sizes of ramps [unit/d]
    # standard deviation of the shifts of fault-free levels, up or down [unit]
    shift: Annotated[float, "unit of the quantity"] = 0.0
    wrong: Annotated[float, ""] = 0.01  # share of wrong drives [-]
    beginnings: int = 26  # number of latest drives at which a change may have begun
    side: Annotated[float, ""] = 1.0  # 1 for rising levels, -1 for falling ones

    def __post_init__(self) -> None:
        if not (self.step > 0.0 and self.ramp > 0.0 and self.shift >= 0.0 and self.beginnings >= 1):
            raise ParameterError(f"{self}: step and ramp must be positive, shift not negative, beginnings at least 1")
        if not 0.0 < self.wrong < 1.0:
            raise ParameterError(f"the share of wrong drives is {self.wrong}; expected more than 0 and less than 1")
        if abs(self.side) != 1.0:
            raise ParameterError(f"side is {self.side}; expected 1 for rising or -1 for falling levels")


class Right(NamedTuple):
    """Logarithms of the probabilities that drives are right and that they are wrong, without a change."""

    right: np.ndarray
    wrong: np.ndarray


def right(normal: np.ndarray, wrong: float) -> Right:
    """Probabilities that drives are right and wrong, if the car has not changed.

    Innovations of wrong drives have a Cauchy distribution `WRONG` times as wide: its tail is so heavy that a single
    drive, however far off, never proves a change.
    """
    usual = np.log1p(-wrong) - 0.5 * (normal**2 + np.log(2.0 * np.pi))
    far = np.log(wrong / (np.pi * WRONG)) - np.log1p((normal / WRONG) ** 2)
    both = np.logaddexp(usual, far)
    return Right(usual - both, far - both)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence accumulated up to each drive."""

    # of the statistic in days after each drive, (cars, drives); without a drive, that of the drive before
    logarithm: np.ndarray
    kind: np.ndarray  # of the likeliest change after each drive, `STEP` or `RAMP`, (cars, drives)
    began: np.ndarray  # first drive that the likeliest change affects, (cars, drives)
    size: np.ndarray  # of the likeliest change [unit] or [unit/d], with its standard deviation, (cars, drives) each
    size_deviation: np.ndarray
    shift: np.ndarray  # of the level by that change so far [unit], (cars, drives)
    # earliest, latest: drives between which it began with 90 % posterior probability, (cars, drives)
    earliest: np.ndarray
    latest: np.ndarray


def evidence(drives: Drives, found: Filtered, changes: Changes) -> Evidence:
    """The statistic of every car after each drive, and the change that explains it best."""
    cars, count = drives.day.shape
    rows = observed(drives)
    search = _Search(cars, min(changes.beginnings, count), rows.shape[2], changes)
    shape = (cars, count)
    result = Evidence(
        np.full(shape, -np.inf), *(np.zeros(shape, int) for _ in range(2)), *(np.zeros(shape) for _ in range(3)),
        *(np.zeros(shape, int) for _ in range(2)),
    )  # fmt: skip
    present = drives.present
    for k in range(count):
        there = present[:, k]
        variance = np.where(there, found.variance[:, k], 1.0)
        normal = np.where(there, found.innovation[:, k], 0.0) / np.sqrt(variance)
        search.step(k, rows[:, k], found.gap[:, k], there, normal, variance, found.gain[:, k])
        search.conclude(k, there, result)
    return result


class _Search:
    """Running sums for the latest beginnings, steps first, then ramps; the newest beginning replaces the oldest."""

    def __init__(self, cars: int, beginnings: int, order: int, changes: Changes):
        self.changes, self.beginnings = changes, beginnings
        self.kinds = np.repeat((STEP, RAMP), beginnings)
        self.deviation = np.where(self.kinds == STEP, changes.step, changes.ramp)
        self.score = np.zeros((cars, 2 * beginnings))
        self.information = np.zeros_like(self.score)
        self.single = np.zeros_like(self.score)  # logarithm of the ratio that score and information give
        self.ratio = np.zeros_like(self.score)  # logarithm of the ratio with wrong drives
        self.signature = np.zeros_like(self.score)
        self.response = np.zeros((cars, 2 * beginnings, order))
        self.days = np.zeros_like(self.score)
        self.begun = np.zeros(2 * beginnings, int)
        self.shifts = FaultFreeShifts(cars, beginnings, changes.shift)

    def step(
        self,
        k: int,
        row: np.ndarray,
        gap: np.ndarray,
        there: np.ndarray,
        normal: np.ndarray,
        variance: np.ndarray,
        gain: np.ndarray,
    ) -> None:
        ramps = slice(self.beginnings, None)
        self.response[:, :, LEVEL] += gap[:, None] * self.response[:, :, SLOPE]
        self.signature[:, ramps] += np.where(self.days[:, ramps] > 0.0, gap[:, None], 0.0)
        for kind in (STEP, RAMP):
            self._begin(kind * self.beginnings + k % self.beginnings, k, gap, kind)
        self.shifts.begin(k % self.beginnings, gap)
        expected = np.einsum("cmi,ci->cm", self.response, row)
        unexplained = np.where(there[:, None], self.signature - expected, 0.0)
        self._weigh(unexplained / np.sqrt(variance)[:, None], normal)
        self.response += unexplained[:, :, None] * gain[:, None, :]

    def _weigh(self, signature: np.ndarray, normal: np.ndarray) -> None:
        """Ratios with one more drive, which enters the sums of a change where it is more likely right than wrong."""
        score = self.score + signature * (self.changes.side * normal)[:, None]
        information = self.information + signature**2
        single = half_normal_ratio(score, information, self.deviation)
        odds = right(normal, self.changes.wrong)
        with_change = odds.right[:, None] + single - self.single
        counts = with_change > odds.wrong[:, None]
        steps = slice(None, self.beginnings)
        self.shifts.step(score[:, steps], information[:, steps], counts[:, steps], odds.right, odds.wrong)
        self.ratio += np.logaddexp(odds.wrong[:, None], with_change)
        np.copyto(self.score, score, where=counts)
        np.copyto(self.information, information, where=counts)
        np.copyto(self.single, single, where=counts)

    def _begin(self, slot: int, k: int, gap: np.ndarray, kind: int) -> None:
        for each in (self.score, self.information, self.single, self.ratio):
            each[:, slot] = 0.0
        self.response[:, slot] = 0.0
        self.days[:, slot] = gap  # no change can have begun before the first drive, nor where there is none
        self.signature[:, slot] = np.where(gap > 0.0, 1.0 if kind == STEP else 0.5 * gap, 0.0)
        self.begun[slot] = k

    def logarithms(self) -> np.ndarray:
        """Logarithm of each beginning's part of the statistic; minus infinity where no change can have begun."""
        # Steps and ramps are equally likely: each kind gets half of the days.
        with np.errstate(divide="ignore"):
            weight = np.log(0.5 * self.days)
        return np.asarray(weight + self.ratio - np.tile(self.shifts.ratio, 2))

    def conclude(self, k: int, there: np.ndarray, result: Evidence) -> None:
        parts = self.logarithms()
        top = parts.max(axis=1)
        sane = np.isfinite(top)
        shares = np.exp(parts - np.where(sane, top, 0.0)[:, None])
        whole = shares.sum(axis=1)
        with np.errstate(divide="ignore"):
            now = np.where(sane, top + np.log(whole), -np.inf)
        best, line = parts.argmax(axis=1), np.arange(len(parts))
        precise = self.information[line, best] + 1.0 / self.deviation[best] ** 2
        result.logarithm[:, k] = np.where(there, now, result.logarithm[:, k - 1] if k else now)
        result.kind[:, k], result.began[:, k] = self.kinds[best], self.begun[best]
        result.size[:, k] = self.changes.side * self.score[line, best] / precise
        result.size_deviation[:, k] = 1.0 / np.sqrt(precise)
        result.shift[:, k] = result.size[:, k] * self.signature[line, best]
        order = np.argsort(self.begun, kind="stable")
        summed = np.cumsum(shares[:, order], axis=1) / np.where(whole > 0.0, whole, 1.0)[:, None]
        last = len(order) - 1
        result.earliest[:, k] = self.begun[order][np.minimum((summed < 0.05).sum(axis=1), last)]
        result.latest[:, k] = self.begun[order][np.minimum((summed < 0.95).sum(axis=1), last)]


def half_normal_ratio(score: np.ndarray, information: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Logarithm of the mean of exp(a d - a^2 c / 2) over a positive, half-normal size a."""
    from scipy.special import log_ndtr

    precise = information + 1.0 / deviation**2
    normal = score / np.sqrt(precise)
    return np.asarray(np.log(2.0) + log_ndtr(normal) + 0.5 * (normal**2 - np.log(precise * deviation**2)))


class FaultFreeShifts:
    """Probability that the last shift was at each stored beginning, and the likelihood ratio of levels with shifts.

    Args:
        deviation: standard deviation of the sizes [unit]
    """

    def __init__(self, cars: int, beginnings: int, deviation: float):
        self.deviation = deviation
        self.none = np.ones(cars)
        self.share = np.zeros((cars, beginnings))
        self.single = np.zeros((cars, beginnings))
        # Log-likelihood ratio of a level that may shift against one that does not, accumulated since each beginning.
        self.ratio = np.zeros((cars, beginnings))

    def begin(self, slot: int, gap: np.ndarray) -> None:
        """Let shifts begin at a drive, in place of the oldest beginning.

        Args: gap: time since the drive before [d], (cars,).
        """
        # The filter has followed the shifts of the replaced beginning, so their probability goes to "no shift".
        self.none += self.share[:, slot]
        new = -np.expm1(-gap / EVERY)
        self.none *= 1.0 - new
        self.share *= (1.0 - new)[:, None]
        self.share[:, slot], self.single[:, slot], self.ratio[:, slot] = new, 0.0, 0.0

    def step(
        self, score: np.ndarray, information: np.ndarray, counts: np.ndarray, right: np.ndarray, wrong: np.ndarray
    ) -> None:
        single = normal_ratio(score, information, self.deviation)
        self.share *= np.exp(wrong)[:, None] + np.exp(right[:, None] + single - self.single)
        whole = self.none + self.share.sum(axis=1)
        self.none /= whole
        self.share /= whole[:, None]
        self.ratio += np.log(whole)[:, None]
        np.copyto(self.single, single, where=counts)


def normal_ratio(score: np.ndarray, information: np.ndarray, deviation: float) -> np.ndarray:
    """Logarithm of the mean of exp(a d - a^2 c / 2) over a normal size a of mean zero."""
    more = 1.0 + information * deviation**2
    return np.asarray(0.5 * ((score * deviation) ** 2 / more - np.log(more)))


DAYS_PER_YEAR = 365.25


def alarm_level(vehicle_years: float) -> float:
    """Threshold of an alarm: logarithm of the statistic in days.

    Args: vehicle_years: smallest mean time between false alarms of fault-free cars [a].
    """
    if not 0.0 < vehicle_years < math.inf:
        raise ParameterError(f"{vehicle_years} vehicle-years between false alarms; expected a positive number")
    return math.log(DAYS_PER_YEAR * vehicle_years)


def log_e_values(logarithm: np.ndarray, watched: np.ndarray, horizon: float) -> np.ndarray:
    """Logarithm of the e-value of every car now.

    The share of the horizon that is left counts for changes that have not begun yet. Beyond the horizon the statistic
    is divided by the time watched.

    Args: watched: time since the first drive of the car [d], (cars,); horizon: time over which a change is equally
    likely to begin [d], such as the life of a car.
    """
    left = np.maximum(1.0 - watched / horizon, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.logaddexp(logarithm - np.log(np.maximum(watched, horizon)), np.log(left)))


def stopped(logarithm: np.ndarray, level: float) -> np.ndarray:
    """Index of the drive at which each car's e-value is taken: the first one at or above a level, or else the last one.

    A car that has reached the level once stays changed, although the search drops old beginnings and the filter follows
    the new level. The first passage is a stopping time, at which the statistic still is an e-value.
    """
    reached = logarithm >= level
    return np.asarray(np.where(reached.any(axis=1), reached.argmax(axis=1), logarithm.shape[1] - 1))


def selected(log_e: np.ndarray, share: float) -> np.ndarray:
    """The changed cars, selected so that on average at most a share of them is fault-free.

    Source: R. Wang, A. Ramdas, 2022, doi 10.1111/rssb.12489: the k largest, with the largest k for which the k-th is at
    least cars / (share k).
    """
    _check(share)
    order = np.argsort(-log_e, kind="stable")
    ranks = np.arange(1, len(log_e) + 1)
    enough = np.flatnonzero(log_e[order] >= math.log(max(len(log_e), 1) / share) - np.log(ranks))
    chosen = np.zeros(len(log_e), bool)
    if len(enough):
        chosen[order[: enough[-1] + 1]] = True
    return chosen


def _check(share: float) -> None:
    if not 0.0 < share < 1.0:
        raise ParameterError(f"the false-discovery rate is {share}; expected more than 0 and less than 1")


HORIZON = 3652.5  # Prediction horizon [d]: ten years. A later time counts as never.
_STEPS = 60


def chance_by(level: np.ndarray, covariance: np.ndarray, limit: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """Probability that the level is above the limit at a time ahead. Args: ahead: time from now [d], (cars,)."""
    from scipy.special import ndtr

    mean = level[:, 0] + ahead * level[:, 1]
    variance = covariance[:, 0, 0] + 2.0 * ahead * covariance[:, 0, 1] + ahead**2 * covariance[:, 1, 1]
    return np.asarray(ndtr((mean - limit) / np.sqrt(np.maximum(variance, 1e-30))))


def time_to_limit(level: np.ndarray, covariance: np.ndarray, limit: np.ndarray, share: float) -> np.ndarray:
    """Time from now at which the probability of being above the limit reaches a share [d]; infinite beyond `HORIZON`.

    The first passage is bracketed on a grid of times that grow by a twelfth, then bisected, since the probability need
    not be monotonic for a falling slope. The trend is extrapolated without process noise.

    Args: share: probability [-]; 0.05 for the earliest time, 0.5 for the median.
    """
    times = np.concatenate(([0.0], np.geomspace(1.0, HORIZON, 104)))
    low, high = np.zeros(len(level)), np.full(len(level), np.inf)
    for before, after in zip(np.concatenate(([0.0], times[:-1])), times, strict=True):
        reached = chance_by(level, covariance, limit, np.full(len(level), after)) >= share
        new = reached & np.isinf(high)
        low[new], high[new] = before, after
    known = np.isfinite(high)
    top = np.where(known, high, 1.0)
    for _ in range(_STEPS):
        middle = 0.5 * (low + top)
        reached = chance_by(level, covariance, limit, middle) >= share
        low, top = np.where(reached, low, middle), np.where(reached, middle, top)
    return np.where(known, top, np.inf)
