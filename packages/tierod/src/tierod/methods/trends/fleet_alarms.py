"""Alarms of a fleet: a bound of the false alarms of each car, and a list of cars with a bounded false-discovery rate.

The statistic in days of `change_evidence` divided by a horizon is an e-value of the car at any stopping time: its mean
without a change is at most 1. The e-BH rule therefore bounds the share of fault-free cars in a list that may be updated
after every drive, for any dependence between cars (a heat wave acts on all of them).
"""

from __future__ import annotations

import math

import numpy as np

from tierod.core.errors import ParameterError

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
