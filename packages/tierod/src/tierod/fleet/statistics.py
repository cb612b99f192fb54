"""Statistics of a fleet, learnt before any single car is judged: noise, prior, and the changes to detect."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tierod.core.errors import InputError, ParameterError
from tierod.core.shown import plus_minus
from tierod.fleet.series import Series
from tierod.methods.analysis.consistency import usual_deviation
from tierod.methods.trends.change_evidence import Changes
from tierod.methods.trends.drive_filter import Drives, Prior, TrendNoise
from tierod.methods.trends.drive_scatter import (
    EVERY,
    FEWEST_CARS,
    Cohort,
    Cohorts,
    DriveScatter,
    Wandering,
    cohorts,
    drive_scatter,
    wandering,
)

TEMPERATURE, MILEAGE = 0, 1  # Indices of the regressors of a series

MANY = 30  # Number of cars from which the effect of mileage is estimated between cars

APART = 0.5  # Standard deviation of the cars' mileages required for that estimate [10 000 km]

ONSET = 90.0
"""Time in which an ageing that reaches the limit within a year may set in; gives the random walk of the slope [d]."""

YEAR = 365.0

WIDE = 3.0
"""Ratio of a car's spread to that of the median car beyond which the car is excluded from the fault-free statistics."""

WRONG_LEAST = 0.002
"""Lower bound of the share of outlier drives: no fleet is large enough to exclude one in five hundred."""


@dataclass(frozen=True, eq=False)
class Learnt:
    """Statistics of one quantity over the fleet."""

    noise: TrendNoise  # noise model of cars that may age, for levels and trends
    steady: TrendNoise  # noise model of cars that do not age, as the fault-free hypothesis of the change detection
    prior: Prior  # prior of a car before its first drive
    changes: Changes
    scatter: DriveScatter
    wander: Wandering  # drift of the fault-free cars
    remarks: tuple[str, ...]

    def with_usual(self, usual: np.ndarray, between: float) -> Learnt:
        """The same statistics for cars whose expected levels are known from their cohorts."""
        mean = np.tile(self.prior.mean, (len(usual), 1))
        mean[:, 0] = usual
        covariance = self.prior.covariance.copy()
        # Few cars that happen to agree do not show how far the next one may differ.
        least = covariance[0, 0] if len(usual) < MANY else 1e-18
        covariance[0, 0] = max(between**2, least)
        return replace(self, prior=Prior(mean, covariance))


def learnt(series: Series) -> Learnt:
    """Estimate noise and prior from the fault-free majority of a fleet."""
    drives, remarks = series.drives, []
    usual = drives
    try:
        scatter = drive_scatter(drives)
        # Twice: without cars that scatter widely, which would widen the statistics of the others.
        usual = drives.of(_usual(drives, scatter.effects))
        scatter = drive_scatter(usual)
    except InputError as error:
        stated = drives.deviation[drives.present]
        scatter = DriveScatter(float(np.median(stated)), 1.0, 0.01, np.zeros(2), np.full(2, np.inf), 0, False)
        remarks.append(f"{error}; until then the scatter is assumed as large as the stated deviations")
    mileage, mileage_deviation = _mileage_effect(series, scatter.effects)
    # Within a month mileage hardly grows, so that its effect is only identifiable between cars.
    effects = np.array([scatter.effects[TEMPERATURE], mileage])
    wander = wandering(usual, effects)
    if wander.longest < 60.0:
        remarks.append("the fleet has been followed for less than two months; its usual wear is not known yet")
    size = _size(series, scatter)
    # A drift not yet observed is bounded by a twentieth of the distance to the limit per year.
    walk = wander.level_walk if wander.longest else 0.05 * size / np.sqrt(YEAR)
    slope_deviation = wander.slope_deviation if wander.longest else 0.02 * size / YEAR
    total = float(np.hypot(scatter.scatter, scatter.scale * np.median(drives.deviation[drives.present])))
    steady = TrendNoise(walk, 0.0, max(scatter.scatter, 0.05 * total), scatter.scale)
    centre, spread = _levels(series, effects)
    temperature_deviation = min(0.3 * abs(effects[TEMPERATURE]) + 0.002 * size / 10.0, scatter.differing[TEMPERATURE])
    variances = (spread**2, slope_deviation**2, temperature_deviation**2, mileage_deviation**2)
    return Learnt(
        replace(steady, slope_walk=size / YEAR / np.sqrt(ONSET)),
        steady,
        Prior(np.array([centre, wander.slope, *effects]), np.diag(variances)),
        Changes(
            size / 3.0,
            size / 3.0 / 100.0,
            walk * np.sqrt(EVERY),
            max(scatter.wrong_share, WRONG_LEAST),
            side=side_of(series),
        ),
        scatter,
        wander,
        tuple(remarks),
    )


def side_of(series: Series) -> float:
    """Sign of the direction of a fault: -1 where the limit lies below the nominal values, else 1."""
    both = np.isfinite(series.limit) & np.isfinite(series.nominal)
    return -1.0 if both.any() and float(np.median((series.limit - series.nominal)[both])) < 0.0 else 1.0


def _size(series: Series, scatter: DriveScatter) -> float:
    """Distance from nominal value to limit [unit]; ten times the scatter of a drive where no limit is known."""
    distance = np.abs(series.limit - series.nominal)
    known = distance[np.isfinite(distance) & (distance > 0.0)]
    if len(known):
        return float(np.median(known))
    stated = float(np.median(series.drives.deviation[series.drives.present]))
    return 10.0 * max(float(np.hypot(scatter.scatter, scatter.scale * stated)), 1e-9)


def _levels(series: Series, effects: np.ndarray) -> tuple[float, float]:
    """Median of the cars' median levels, and standard deviation of the cars about it [unit]."""
    middle = np.nanmedian(_corrected(series.drives, effects), axis=1)
    centre = float(np.median(middle))
    spread = usual_deviation(middle - centre)
    known = series.nominal[np.isfinite(series.nominal)]
    if len(middle) < MANY:
        # Few cars do not show the spread from car to car: at least a tenth of the nominal value is assumed, and the
        # spread of the drives, as the median of a car whose level stepped may be neither of its levels.
        values = _corrected(series.drives, effects)[series.drives.present]
        nominal = abs(float(np.median(known))) if len(known) else 0.0
        spread = max(spread, 0.1 * nominal, usual_deviation(values - centre))
    return centre, max(spread, 1e-3 * abs(centre), 1e-9)


def _usual(drives: Drives, effects: np.ndarray) -> np.ndarray:
    """Cars without a wide scatter about their own median, (cars,); changed cars would widen the statistics."""
    value = _corrected(drives, np.array([effects[TEMPERATURE], 0.0]))
    spread = np.nanquantile(np.abs(value - np.nanmedian(value, axis=1, keepdims=True)), 0.9, axis=1)
    return np.asarray(spread <= WIDE * np.median(spread))


def _mileage_effect(series: Series, effects: np.ndarray) -> tuple[float, float]:
    """Change per 10 000 km between cars, and its standard deviation; zeros if the mileages are too similar."""
    known = np.isfinite(series.mileage)
    if known.sum() < MANY or float(np.std(series.mileage[known])) < APART:
        return 0.0, 0.0
    middle = np.nanmedian(_corrected(series.drives, np.array([effects[TEMPERATURE], 0.0])), axis=1)[known]
    along = series.mileage[known] + np.nanmedian(series.drives.effects[known, :, MILEAGE], axis=1)
    design = np.stack((np.ones(len(along)), along), axis=1)
    weight, found, size = np.ones(len(along)), np.zeros(2), 1.0
    # Iteratively reweighted least squares (Huber), so that faulty cars do not bend the line.
    for _ in range(20):
        found = np.linalg.lstsq(design * np.sqrt(weight)[:, None], middle * np.sqrt(weight), rcond=None)[0]
        rest = middle - design @ found
        size = max(usual_deviation(rest), 1e-12)
        weight = 1.0 / np.maximum(1.0, np.abs(rest) / (1.5 * size))
    inverse = np.linalg.inv(design.T @ (weight[:, None] * design))
    return float(found[1]), float(size * np.sqrt(inverse[1, 1]))


def _corrected(drives: Drives, effects: np.ndarray) -> np.ndarray:
    """Estimates corrected to the reference of the regressors; NaN where there is no drive."""
    return np.asarray(np.where(drives.present, drives.estimate - drives.effects @ effects, np.nan))


NOMINAL = {"friction torque at the steering wheel axis": "nominal_friction"}
"""Quantity of a finding, and the parameter of a vehicle file that holds its fault-free value."""


@dataclass(frozen=True, eq=False)
class Cohorted:
    """Cohort effects of one quantity."""

    # every cohort with its odds, and the spread from car to car; None if the fleet has too few cars
    cohorts: Cohorts | None
    remark: str = ""

    @property
    def differing(self) -> tuple[Cohort, ...]:
        """Cohorts whose odds of differing from the fleet exceed one."""
        return () if self.cohorts is None else tuple(each for each in self.cohorts.all if each.log_odds > 0.0)


def cohorted(series: Series, level: np.ndarray, deviation: np.ndarray, known: Learnt) -> Cohorted:
    if len(level) < FEWEST_CARS:
        return Cohorted(None, f"{len(level)} cars are too few to compare cohorts; {FEWEST_CARS} are the least")
    return Cohorted(cohorts(level, deviation, series.labels, 0.5 * known.changes.step))


@dataclass(frozen=True)
class Expected:
    """Level expected of a new car."""

    value: float  # value, standard_deviation: its fault-free level and standard deviation [unit]
    standard_deviation: float
    source: str  # origin of the value in words, for a vehicle file


def expected_of(found: Cohorts, series: Series, labels: dict[str, str]) -> Expected:
    """Level expected of a new car, from the fleet mean and the effects of its cohorts."""
    for kind, name in labels.items():
        known = sorted({each for each in series.labels.get(kind, ()) if each})
        if name not in known:
            raise ParameterError(
                f"no car of the fleet has {kind} '{name}'; known are {', '.join(known[:10]) or 'none of that kind'}"
            )
    mine = [each for each in found.all if labels.get(each.kind) == each.name and each.log_odds > 0.0]
    value = found.mean + sum(each.effect for each in mine)
    variance = found.between**2 + found.deviation**2 + sum(each.deviation**2 for each in mine)
    cohort = ", ".join(f"{each.kind} {each.name} ({each.effect:+.3g})" for each in mine)
    source = (
        f"fleet of {len(series.vehicles)} cars: mean {found.mean:.4g} with {found.between:.3g} from car to car"
        + (f"; {cohort}" if cohort else "")
        + f", {series.watched.unit}"
    )
    return Expected(float(value), math.sqrt(variance), source)


def write_prior(path: str | Path, series: Series, expected: Expected) -> Path:
    """Write the level expected of a new car into a vehicle file, as value, standard deviation and source."""
    from tierod.core.files import write_text
    from tierod.vehicles import load
    from tierod.vehicles.writer import Change, changed

    quantity = series.watched.quantity
    if quantity not in NOMINAL:
        raise ParameterError(
            f"no parameter of a vehicle file holds the fault-free value of '{quantity}'; known are {', '.join(NOMINAL)}"
        )
    target = Path(path)
    load(target)  # an error in the file is reported with its line before anything is written
    try:
        text = target.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{target} cannot be read: {error.strerror}; check its path and permissions") from None
    change = Change(expected.value, expected.standard_deviation, expected.source)
    return write_text(target, changed(text, {NOMINAL[quantity]: change}))


def written_prior(found: Sequence[tuple[Series, Cohorted]], path: Path, cohort: Sequence[str]) -> str:
    """Write the level expected of a new car into a vehicle file; returns a sentence on it.

    Args:
        cohort: cohorts of the new car, each as KIND=NAME
    """
    labels = {}
    for each in cohort:
        kind, equals, name = each.partition("=")
        if not (kind and equals and name):
            raise ParameterError(f"--cohort is '{each}'; expected KIND=NAME, such as 'rack batch=2025-47'")
        labels[kind.strip()] = name.strip()
    series, learnt = next((each for each in found if each[0].watched.quantity in NOMINAL), (None, None))
    if series is None or learnt is None or learnt.cohorts is None:
        why = "no quantity with a nominal value is followed" if learnt is None else learnt.remark
        raise InputError(f"these results give no expected level of a new car: {why}")
    expected = expected_of(learnt.cohorts, series, labels)
    write_prior(path, series, expected)
    size = plus_minus(expected.value, expected.standard_deviation, series.watched.unit)
    return f"{path}: {NOMINAL[series.watched.quantity]} is {size} ({expected.source})"
