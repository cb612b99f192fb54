"""Scatter between drives of one car, wandering of its level, and cohorts of cars that differ from the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.analysis.consistency import VARIANCE_ERROR, usual_deviation
from tierod.methods.trends.drive_filter import Drives

LEAST = 30  # Smallest number of pairs of drives for an estimate: they give a standard deviation to 13 %
# Largest number of pairs that are used, evenly spaced among all: they give a standard deviation to 0.11 %
MOST = 400_000
NEAR = 30.0  # Longest time between two drives of a pair [d], over which wear is negligible
WRONG = 5.0  # Standard deviation of wrong drives (outliers) over that of the others [-]


@dataclass(frozen=True)
class DriveScatter:
    """Estimated scatter of drives of the same car."""

    scatter: float  # standard deviation from drive to drive beside the stated ones [unit]
    # true error over the stated one [-]; where the stated deviations are too alike to separate both, 1 or less
    scale: float
    wrong_share: float
    effects: np.ndarray  # change of the estimate per unit of each regressor, (regressors,)
    differing: np.ndarray  # upper estimate of the standard deviation of each effect from car to car, (regressors,)
    pairs: int
    separated: bool


def drive_scatter(drives: Drives) -> DriveScatter:
    """Maximum-likelihood estimate of scatter and scale from the differences between neighbouring drives of each car.

    Differences do not depend on the level of the car, and hardly on its wear. Their likelihood is that of two Gaussian
    errors, each of which may be an outlier, so that a few wrong drives do not widen it. It is a composite likelihood,
    since neighbouring differences share a drive; the estimates stay consistent. Source: C. Varin et al., 2011,
    Statistica Sinica 21, 5-42; outliers after J. W. Tukey, 1960.
    """
    from scipy.optimize import minimize

    change, first, second, moved = _pairs(drives)
    if len(change) < LEAST:
        raise InputError(
            f"{len(change)} pairs of drives of the same car within {NEAR:g} days; the scatter between drives is learnt "
            f"from {LEAST} or more: give more drives, or state the scatter"
        )
    effects = _robust_slopes(change, moved)
    rest = change - moved @ effects
    stated = first**2 + second**2
    level = usual_deviation(rest)
    low, high = np.quantile(stated, (0.1, 0.9))
    # Only stated deviations that differ between drives separate the scale from a constant scatter.
    separated = bool(high > 2.0 * low)
    begin = [np.log(max(level, 1e-9) / np.sqrt(2.0)), np.log(0.5) if separated else -np.inf, np.log(0.03 / 0.97)]

    def unlikely(values: np.ndarray) -> float:
        scatter, share = np.exp(values[0]), 1.0 / (1.0 + np.exp(-values[1]))
        scale = np.exp(values[2]) if separated else 0.0
        variance = scale**2 * stated + 2.0 * scatter**2
        return -float(np.sum(_mixture(rest**2, variance, share)))

    start = np.array([begin[0], begin[2], begin[1]] if separated else [begin[0], begin[2]])
    best = minimize(unlikely, start, method="Nelder-Mead", options={"maxiter": 2000, "fatol": 1e-3, "xatol": 1e-4}).x
    scatter, share = float(np.exp(best[0])), float(1.0 / (1.0 + np.exp(-best[1])))
    scale = float(np.exp(best[2])) if separated else _rest_scale(scatter, stated)
    scatter = scatter if separated else _rest_scatter(scatter, stated)
    return DriveScatter(scatter, scale, share, effects, _differing(rest, moved), len(change), separated)


def _rest_scale(whole: float, stated: np.ndarray) -> float:
    """Scale where it cannot be separated from the scatter: 1, or less where the drives scatter less than they state."""
    return float(min(1.0, whole / np.sqrt(0.5 * np.median(stated))))


def _rest_scatter(whole: float, stated: np.ndarray) -> float:
    return float(np.sqrt(max(whole**2 - 0.5 * float(np.median(stated)), 0.0)))


def _mixture(square: np.ndarray, variance: np.ndarray, share: float) -> np.ndarray:
    chances = ((1.0 - share) ** 2, 2.0 * share * (1.0 - share), share**2)
    wider = (1.0, 0.5 * (1.0 + WRONG**2), WRONG**2)
    parts = [
        np.log(chance / np.sqrt(wide)) - 0.5 * square / (wide * variance)
        for chance, wide in zip(chances, wider, strict=True)
    ]
    return np.asarray(np.logaddexp.reduce(parts) - 0.5 * np.log(variance))


def _pairs(drives: Drives) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    both = drives.present[:, 1:] & drives.present[:, :-1]
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(both & (np.diff(drives.day, axis=1) <= NEAR))
    near = near[:: max(-(-len(near) // MOST), 1)]
    car, first = np.unravel_index(near, both.shape)
    effects = drives.effects
    return (
        drives.estimate[car, first + 1] - drives.estimate[car, first],
        drives.deviation[car, first],
        drives.deviation[car, first + 1],
        effects[car, first + 1] - effects[car, first],
    )


def _differing(rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Standard deviations of effects from car to car, from the wider scatter of pairs with large regressor differences.

    Each variance is its estimate, at least zero, plus its standard error: an upper value that the drives allow.
    """
    found = np.full(moved.shape[1], np.inf)
    for number, along in enumerate(moved.T**2):
        far = along > np.median(along)
        more = along[far].mean() - along[~far].mean() if far.any() else 0.0
        if more <= 0.0:
            continue
        wide, near = (usual_deviation(rest[of]) ** 2 for of in (far, ~far))
        error = VARIANCE_ERROR * np.hypot(wide, near) / np.sqrt(0.5 * len(rest))
        found[number] = np.sqrt((max(wide - near, 0.0) + error) / more)
    return found


def _robust_slopes(change: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Least squares with Huber's weights; a ridge keeps the coefficients of nearly constant regressors near zero."""
    weight = np.ones(len(change))
    count = moved.shape[1]
    if not count:
        return np.zeros(0)
    ridge = 1e-6 * np.eye(count)
    slopes = np.zeros(count)
    for _ in range(20):
        normal = moved.T @ (weight[:, None] * moved)
        slopes = np.linalg.solve(normal + ridge * max(np.trace(normal), 1e-12), moved.T @ (weight * change))
        rest = change - moved @ slopes
        size = max(usual_deviation(rest), 1e-12)
        weight = 1.0 / np.maximum(1.0, np.abs(rest) / (1.5 * size))
    return slopes


LEAST_PAIRS = 50  # Smallest number of pairs of drives for a point of the variogram


@dataclass(frozen=True)
class Wandering:
    level_walk: float  # random walk of the level [unit/sqrt(d)]; its variance includes its standard error
    slope: float  # median slope of the cars [unit/d]
    slope_deviation: float  # standard deviation from car to car [unit/d]; its variance includes its standard error
    longest: float  # largest time between drives that was used [d]; 0 where nothing could be estimated


def wandering(drives: Drives, effects: np.ndarray) -> Wandering:
    """Walk and slopes from a robust variogram: variance of the difference of two drives over the time between them.

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
        if both.sum() < LEAST_PAIRS:
            break
        apart = (drives.day[:, offset:] - drives.day[:, :-offset])[both]
        change = (value[:, offset:] - value[:, :-offset])[both]
        usual = float(np.median(apart))
        near = (apart > 0.5 * usual) & (apart < 2.0 * usual)
        if near.sum() < LEAST_PAIRS or not 0.0 < usual < EVERY:
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


FEWEST_CARS = 3  # Smallest number of cars inside and outside a cohort that is tested
# Number of common cars over that of the cars in either cohort, from which on two cohorts cannot be separated
ALIKE = 0.8


@dataclass(frozen=True)
class Cohort:
    kind: str  # kind, name: such as "rack batch" and "2026-03"
    name: str
    cars: int
    # effect, deviation: of its cars against the rest, shrunk towards zero by the prior of effects [unit], and its
    # standard deviation
    effect: float
    deviation: float
    log_odds: float  # natural logarithm of the odds that it differs
    # other cohorts of nearly the same cars, as (kind, name); the effect may be theirs
    alike: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Cohorts:
    """The fleet as a mixed model."""

    # mean, deviation: mean of the cars with the effects of their cohorts removed, and its standard deviation [unit]
    mean: float
    deviation: float
    between: float  # standard deviation from car to car [unit]
    all: tuple[Cohort, ...]
    usual: np.ndarray = field(repr=False)  # expected value of each car with its cohorts' effects, (cars,)


def cohorts(
    value: np.ndarray,
    deviation: np.ndarray,
    labels: Mapping[str, Sequence[str]],
    effect: float,
    prior_share: float = 0.01,
) -> Cohorts:
    """Every cohort with the odds that its cars differ from the rest.

    Cohorts are selected one by one while their odds exceed 1, the likeliest first, each tested with the effects
    selected so far removed, so that an effect is not counted twice. Cars far from all others have a bounded weight.

    Args: value, deviation: estimate of each car and its standard deviation [unit], (cars,); labels: kind of cohort ->
    name of each car's cohort, "" where it is not known; effect: standard deviation of the effects of cohorts that
    differ [unit].
    """
    if len(value) < FEWEST_CARS:
        raise InputError(f"{len(value)} cars; cohorts are compared in fleets of {FEWEST_CARS} or more")
    members = {
        (kind, str(name)): np.array([each == name for each in names])
        for kind, names in labels.items()
        for name in sorted({each for each in names if each})
    }
    members = {key: of for key, of in members.items() if FEWEST_CARS <= of.sum() <= len(value) - FEWEST_CARS}
    prior = np.log(prior_share / (1.0 - prior_share))
    taken: dict[tuple[str, str], Cohort] = {}
    effects = np.zeros(len(value))
    while True:
        between, weight = _between(value - effects, deviation)
        open_ = {key: of for key, of in members.items() if key not in taken}
        judged = {key: _judged(key, of, value - effects, weight, effect, prior) for key, of in open_.items()}
        best = max(judged.values(), key=lambda each: each.log_odds, default=None)
        if best is None or best.log_odds <= 0.0:
            break
        key = (best.kind, best.name)
        taken[key] = _with_alike(best, members)
        effects = effects + best.effect * members[key]
    mean = float(weight @ (value - effects) / weight.sum())
    every = sorted((*taken.values(), *judged.values()), key=lambda each: -each.log_odds)
    return Cohorts(mean, float(1.0 / np.sqrt(weight.sum())), between, tuple(every), mean + effects)


def _between(value: np.ndarray, deviation: np.ndarray) -> tuple[float, np.ndarray]:
    """Standard deviation from car to car, and the weight of each car.

    The variance makes the mean of the clipped squared residuals equal to its expectation (R. C. Paule, J. Mandel, 1982,
    with the bound of P. J. Huber's proposal 2).
    """
    centre = float(np.median(value))
    spread = usual_deviation(value - centre)
    between = np.sqrt(max(spread**2 - float(np.median(deviation**2)), 1e-12))
    expected = 0.9205  # mean of min(z^2, 2^2) of a normal z
    for _ in range(50):
        whole = between**2 + deviation**2
        normal = (value - centre) / np.sqrt(whole)
        weight = 1.0 / (whole * np.maximum(1.0, np.abs(normal) / 2.0))
        centre = float(weight @ value / weight.sum())
        ratio = float(np.mean(np.minimum(normal**2, 4.0))) / expected
        between = np.sqrt(max((between**2 + float(np.median(deviation**2))) * ratio - np.median(deviation**2), 1e-12))
    whole = between**2 + deviation**2
    normal = np.abs(value - centre) / np.sqrt(whole)
    return float(between), 1.0 / (whole * np.maximum(1.0, normal / 2.0))


def _judged(
    key: tuple[str, str], of: np.ndarray, value: np.ndarray, weight: np.ndarray, effect: float, prior: float
) -> Cohort:
    # In a cohort that differs every car is far from the fleet's centre, so the weights are taken about its own centre.
    inside, within = _centre(value[of], weight[of].max())
    outside, without = float(weight[~of] @ value[~of] / weight[~of].sum()), 1.0 / float(weight[~of].sum())
    contrast, variance = inside - outside, within + without
    whole = variance + effect**2
    log_odds = prior + 0.5 * (np.log(variance / whole) + contrast**2 * (1.0 / variance - 1.0 / whole))
    shrunk = effect**2 / whole
    return Cohort(key[0], key[1], int(of.sum()), float(shrunk * contrast), float(np.sqrt(shrunk * variance)),
                  float(log_odds))  # fmt: skip


def _centre(value: np.ndarray, highest: float) -> tuple[float, float]:
    """Bounded-influence mean of the cars of a cohort, and its variance; each car weighs at most `highest`."""
    centre = float(np.median(value))
    for _ in range(20):
        weight = highest / np.maximum(1.0, np.abs(value - centre) * np.sqrt(highest) / 2.0)
        centre = float(weight @ value / weight.sum())
    return centre, float(1.0 / weight.sum())


def _with_alike(found: Cohort, members: Mapping[tuple[str, str], np.ndarray]) -> Cohort:
    own = members[found.kind, found.name]
    alike = tuple(
        key
        for key, of in members.items()
        if key != (found.kind, found.name) and (own & of).sum() >= ALIKE * (own | of).sum()
    )
    return Cohort(found.kind, found.name, found.cars, found.effect, found.deviation, found.log_odds, alike)


EVERY = 182.6  # Mean time between shifts of one car [d]: tyres are changed twice a year
