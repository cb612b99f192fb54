"""Alarms of a fleet with bounded false alarms and false discoveries, and the time until a level reaches its limit.

The statistic in days of `change_evidence` divided by a horizon is an e-value of the car at any stopping time: its mean
without a change is at most 1. The e-BH rule therefore bounds the share of fault-free cars in a list that may be updated
after every drive, for any dependence between cars (a heat wave acts on all of them)."""

from __future__ import annotations

import math

import numpy as np

from tierod.core.errors import ParameterError

EVERY = 182.6  # Mean time between shifts of one car [d]: tyres are changed twice a year


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

        Args:
            gap: time since the drive before [d], (cars,)
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
        """Update with one drive.

        Args:
            score, information: of steps from each beginning on, with this drive, (cars, beginnings)
            counts: whether the drive enters the sums of each beginning, (cars, beginnings)
            right, wrong: logarithms of the probabilities that it is right and wrong without any shift, (cars,)
        """
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

    Args:
        vehicle_years: smallest mean time between false alarms of fault-free cars [a]

    Raises:
        ParameterError: a time that is not positive
    """
    if not 0.0 < vehicle_years < math.inf:
        raise ParameterError(f"{vehicle_years} vehicle-years between false alarms; expected a positive number")
    return math.log(DAYS_PER_YEAR * vehicle_years)


def log_e_values(logarithm: np.ndarray, watched: np.ndarray, horizon: float) -> np.ndarray:
    """Logarithm of the e-value of every car now.

    Args:
        logarithm: of the statistic in days, (cars,)
        watched: time since the first drive of the car [d], (cars,)
        horizon: time over which a change is equally likely to begin [d], such as the life of a car

    The share of the horizon that is left counts for changes that have not begun yet. Beyond the horizon the statistic
    is divided by the time watched.
    """
    left = np.maximum(1.0 - watched / horizon, 0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.logaddexp(logarithm - np.log(np.maximum(watched, horizon)), np.log(left)))


def stopped(logarithm: np.ndarray, level: float) -> np.ndarray:
    """Index of the drive at which each car's e-value is taken: the first one at or above a level, or else the last one.

    Args:
        logarithm: of the statistic in days after each drive, (cars, drives)

    A car that has reached the level once stays changed, although the search drops old beginnings and the filter follows
    the new level. The first passage is a stopping time, at which the statistic still is an e-value.
    """
    reached = logarithm >= level
    return np.asarray(np.where(reached.any(axis=1), reached.argmax(axis=1), logarithm.shape[1] - 1))


def selected(log_e: np.ndarray, share: float) -> np.ndarray:
    """The changed cars, selected so that on average at most a share of them is fault-free.

    Args:
        log_e: logarithms of e-values, (cars,)
        share: false-discovery rate, 0 to 1

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
    """Probability that the level is above the limit at a time ahead.

    Args:
        level: mean of level and slope now, (cars, 2)
        covariance: of level and slope, (cars, 2, 2)
        limit: upper limit in the unit of the level, (cars,)
        ahead: time from now [d], (cars,)
    """
    from scipy.special import ndtr

    mean = level[:, 0] + ahead * level[:, 1]
    variance = covariance[:, 0, 0] + 2.0 * ahead * covariance[:, 0, 1] + ahead**2 * covariance[:, 1, 1]
    return np.asarray(ndtr((mean - limit) / np.sqrt(np.maximum(variance, 1e-30))))


def time_to_limit(level: np.ndarray, covariance: np.ndarray, limit: np.ndarray, share: float) -> np.ndarray:
    """Time from now at which the probability of being above the limit reaches a share [d]; infinite beyond `HORIZON`.

    Args:
        limit: upper limit in the unit of the level, (cars,)
        share: probability [-]; 0.05 for the earliest time, 0.5 for the median

    The first passage is bracketed on a grid of times that grow by a twelfth, then bisected, since the probability need
    not be monotonic for a falling slope. The trend is extrapolated without process noise.
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
