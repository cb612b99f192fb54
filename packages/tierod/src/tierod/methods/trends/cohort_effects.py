"""Cohorts of cars that differ from the rest, each with its odds: a mixed model with sparse cohort effects.

value of a car = common mean + effects of its cohorts + deviation of the car + error of its estimate. Most cohorts have
no effect; the effects of the others are normally distributed. The odds of a cohort are its prior odds times the
likelihood ratio of its contrast to the rest, with an effect against without.

Sources: N. M. Laird, J. H. Ware, 1982, doi 10.2307/2529876 (mixed model); T. J. Mitchell, J. J. Beauchamp, 1988, doi
10.1080/01621459.1988.10478694 (effects that are mostly zero).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tierod.core.errors import InputError
from tierod.methods.analysis.noise import usual_deviation

LEAST = 3  # Smallest number of cars inside and outside a cohort that is tested

ALIKE = 0.8
"""Number of common cars over that of the cars in either cohort, from which on two cohorts cannot be separated."""


@dataclass(frozen=True)
class Cohort:
    """A cohort with its effect and the odds that it differs from the rest."""

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

    Args:
        value, deviation: estimate of each car and its standard deviation [unit], (cars,)
        labels: kind of cohort -> name of each car's cohort, "" where it is not known
        effect: standard deviation of the effects of cohorts that differ [unit]

    Cohorts are selected one by one while their odds exceed 1, the likeliest first, each tested with the effects
    selected so far removed, so that an effect is not counted twice. Cars far from all others have a bounded weight.

    Raises:
        InputError: fewer than `LEAST` cars
    """
    if len(value) < LEAST:
        raise InputError(f"{len(value)} cars; cohorts are compared in fleets of {LEAST} or more")
    members = {
        (kind, str(name)): np.array([each == name for each in names])
        for kind, names in labels.items()
        for name in sorted({each for each in names if each})
    }
    members = {key: of for key, of in members.items() if LEAST <= of.sum() <= len(value) - LEAST}
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
