"""Random walk and slope of the levels of fault-free cars, estimated from a fleet in which most cars are fault-free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tierod.methods.trends.drives import Drives
from tierod.methods.trends.fault_free_shifts import EVERY
from tierod.methods.trends.robust import VARIANCE_ERROR, usual_deviation

LEAST = 50
"""Smallest number of pairs of drives for a point of the variogram."""


@dataclass(frozen=True)
class Wandering:
    """Estimated random walk and slope of the levels.

    Args:
        level_walk: random walk of the level [unit/sqrt(d)]; its variance includes its standard error
        slope: median slope of the cars [unit/d]
        slope_deviation: standard deviation from car to car [unit/d]; its variance includes its standard error
        longest: largest time between drives that was used [d]; 0 where nothing could be estimated
    """

    level_walk: float
    slope: float
    slope_deviation: float
    longest: float


def wandering(drives: Drives, effects: np.ndarray) -> Wandering:
    """Walk and slopes from a robust variogram: variance of the difference of two drives over the time between them.

    Args:
        effects: of the regressors on the estimate, (regressors,)

    The variance of the difference of two drives is 2 s^2 + w^2 T + v^2 T^2 over the time T between them, for drive
    scatter s, walk w and slopes of standard deviation v. T goes up to half a year, beyond which the seasons repeat.
    Medians make it robust against a minority of faulty cars. The coefficients are fitted by non-negative least squares;
    the variogram is that of N. Cressie, Statistics for Spatial Data, 1993, 2.4, in its robust form. The standard error
    is added to both variances.
    """
    from scipy.optimize import nnls

    value = drives.estimate - drives.effects @ effects
    distance, spread, drift, pairs = [], [], [], 0
    for offset in 2 ** np.arange(12):
        if offset >= value.shape[1]:
            break
        both = drives.present[:, offset:] & drives.present[:, :-offset]
        if both.sum() < LEAST:
            break
        apart = (drives.day[:, offset:] - drives.day[:, :-offset])[both]
        change = (value[:, offset:] - value[:, :-offset])[both]
        usual = float(np.median(apart))
        near = (apart > 0.5 * usual) & (apart < 2.0 * usual)
        if near.sum() < LEAST or not 0.0 < usual < EVERY:
            continue
        middle = float(np.median(change[near]))
        distance.append(usual)
        drift.append(middle / usual)
        pairs = int(near.sum())
        spread.append(usual_deviation(change[near] - middle) ** 2)
    if len(distance) < 3:
        return Wandering(0.0, 0.0, 0.0, 0.0)
    apart, variance = np.array(distance), np.array(spread)
    # Divided by the variances, the fit minimises relative errors, since the error of a variance is in proportion to it.
    terms = np.stack((np.ones(len(apart)), apart, apart**2), axis=1) / variance[:, None]
    found, _ = nnls(terms, np.ones(len(apart)))
    error = VARIANCE_ERROR / np.sqrt(pairs) * variance[-1]
    walk, slope = np.sqrt(found[1] + error / apart[-1]), np.sqrt(found[2] + error / apart[-1] ** 2)
    return Wandering(float(walk), float(drift[-1]), float(slope), float(apart[-1]))
