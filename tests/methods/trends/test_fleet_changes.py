"""Evidence for changes, alarms of a fleet, and cohorts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, stats

from tierod.core.errors import ParameterError
from tierod.methods.trends.change_evidence import RAMP, STEP, Changes, alarm_level, evidence, time_to_limit
from tierod.methods.trends.drive_filter import Drives, Prior, TrendNoise, filtered
from tierod.methods.trends.drive_scatter import cohorts

NOISE = TrendNoise(level_walk=0.0, slope_walk=0.0, scatter=0.1, scale=1e-6, clip=1e9)
PRIOR = Prior(np.array([4.0, 0.0]), np.diag([0.3**2, 1e-5**2]))
NEVER = 1e-12  # Share of wrong drives with which the statistic is that of Gaussian ones
CHANGES = Changes(step=0.5, ramp=0.01, wrong=NEVER, beginnings=8)


def weekly(cars, count, scatter=0.1, seed=3):
    chance = np.random.default_rng(seed)
    day = 7.0 * np.tile(np.arange(count), (cars, 1)).astype(float)
    level = 4.0 + 0.3 * chance.standard_normal((cars, 1))
    estimate = level + scatter * chance.standard_normal(day.shape)
    return Drives(day, estimate, np.full(day.shape, 0.1), np.zeros((cars, count, 0)))


def with_change(drives, change):
    return Drives(drives.day, drives.estimate + change, drives.deviation, drives.regressors)


def dense_logarithm(drives):
    """Logarithm of the statistic in days of one car: joint normal densities with and without every change."""
    day, values = drives.day[0], drives.estimate[0]
    count = len(day)
    usual = np.full((count, count), 0.3**2) + 1e-10 * np.outer(day, day) + 0.1**2 * np.eye(count)
    total = 0.0
    for j in range(1, count):
        for shape, deviation in (
            (np.where(np.arange(count) >= j, 1.0, 0.0), 0.5),
            (np.maximum(day - 0.5 * (day[j - 1] + day[j]), 0.0), 0.01),
        ):
            inverse = np.linalg.inv(usual)
            score, information = shape @ inverse @ (values - 4.0), shape @ inverse @ shape

            def part(a, score=score, information=information, deviation=deviation):
                return 2.0 * stats.norm.pdf(a, 0.0, deviation) * math.exp(a * score - 0.5 * a * a * information)

            total += 0.5 * 7.0 * integrate.quad(part, 0.0, 12.0 * deviation, limit=400)[0]
    return math.log(total)


@pytest.mark.parametrize("change", [0.0, 0.3])
def test_the_statistic_is_that_of_dense_likelihoods(change):
    drives = with_change(weekly(1, 7), np.where(np.arange(7) >= 4, change, 0.0))
    found = evidence(drives, filtered(drives, PRIOR, NOISE), CHANGES)
    assert found.logarithm[0, -1] == pytest.approx(dense_logarithm(drives), abs=1e-3)


def test_without_a_change_its_mean_is_the_time_watched():
    drives = weekly(60_000, 5, seed=5)
    small = Changes(step=0.06, ramp=0.003, wrong=NEVER, beginnings=8)  # larger ones have means with endless variance
    statistic = np.exp(evidence(drives, filtered(drives, PRIOR, NOISE), small).logarithm)
    for k in (1, 2, 4):
        error = statistic[:, k].std() / math.sqrt(len(statistic))
        assert statistic[:, k].mean() == pytest.approx(7.0 * k, abs=4.0 * error)
        assert 4.0 * error < 3.0 * k


def test_steps_and_ramps_are_found_with_kind_size_and_beginning():
    day = 7.0 * np.arange(20)
    for kind, change, size in (
        (STEP, np.where(day >= 70.0, 0.8, 0.0), 0.8),
        (RAMP, np.maximum(day - 63.0, 0) / 50, 0.02),
    ):
        drives = with_change(weekly(40, 20), change)
        found = evidence(drives, filtered(drives, PRIOR, NOISE), Changes(0.5, 0.01, beginnings=16))
        assert (found.logarithm[:, -1] > alarm_level(10_000.0)).all()
        assert (found.kind[:, -1] == kind).mean() > 0.9
        assert np.median(found.size[:, -1]) == pytest.approx(size, rel=0.15)
        assert ((found.earliest[:, -1] <= 10) & (found.latest[:, -1] >= 10)).mean() >= 0.8


@pytest.mark.parametrize("far", [0.5, 1.0, 5.0, 50.0])
def test_one_wrong_drive_raises_no_alarm_and_missing_ones_change_nothing(far):
    drives = weekly(5, 16)
    estimate = drives.estimate.copy()
    estimate[:, 9] += far
    wrong = Drives(drives.day, estimate, drives.deviation, drives.regressors)
    noise, changes = TrendNoise(0.0, 0.0, 0.1, 1e-6, 2.5), Changes(0.5, 0.01, wrong=0.002, beginnings=16)
    found = evidence(wrong, filtered(wrong, PRIOR, noise), changes)
    assert (found.logarithm < alarm_level(10_000.0) - 4.0).all()
    estimate[:, 9] = np.nan
    without = Drives(drives.day, estimate, drives.deviation, drives.regressors)
    held = evidence(without, filtered(without, PRIOR, noise), changes).logarithm
    np.testing.assert_array_equal(held[:, 9], held[:, 8])


def test_the_level_is_the_time_between_false_alarms():
    assert alarm_level(10_000.0) == pytest.approx(math.log(3_652_500.0))
    with pytest.raises(ParameterError, match="expected a positive number"):
        alarm_level(0.0)


LEVEL = np.array([[5.0, 0.01], [5.0, 0.0], [8.0, 0.0]])
SPREAD = np.array([[[0.01, -1e-5], [-1e-5, 4e-6]], [[0.01, 0.0], [0.0, 1e-12]], [[0.01, 0.0], [0.0, 1e-12]]])
LIMIT = np.full(3, 7.5)


def test_quantiles_are_those_of_drawn_trends():
    drawn = np.random.default_rng(0).multivariate_normal(LEVEL[0], SPREAD[0], 400_000)
    for share in (0.05, 0.5, 0.9):
        at = time_to_limit(LEVEL, SPREAD, LIMIT, share)[0]
        assert np.mean(drawn[:, 0] + at * drawn[:, 1] >= 7.5) == pytest.approx(share, abs=0.003)
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.5)[0] == pytest.approx(250.0)


CARS = 1000


def cohort_fleet(shift, seed=1, between=0.3):
    chance = np.random.default_rng(seed)
    batch = ["odd" if car < 20 else f"batch {car % 40}" for car in range(CARS)]
    supplier = ["A" if car < 20 or car % 3 else "B" for car in range(CARS)]
    value = 4.0 + between * chance.standard_normal(CARS)
    value[:20] += shift
    return value, {"batch": batch, "supplier": supplier, "climate": ["cold", "hot"] * (CARS // 2)}


def test_the_odd_batch_is_named_and_no_other():
    value, labels = cohort_fleet(1.0)
    found = cohorts(value, np.full(CARS, 0.05), labels, 0.5)
    assert (found.all[0].kind, found.all[0].name, found.all[0].cars) == ("batch", "odd", 20)
    assert found.all[0].effect == pytest.approx(1.0, abs=0.2)
    assert found.all[0].log_odds > 20.0
    assert found.all[1].log_odds < 0.0
    assert (found.mean, found.between) == (pytest.approx(4.0, abs=0.03), pytest.approx(0.3, rel=0.1))
    assert found.usual[0] == pytest.approx(found.mean + found.all[0].effect)
