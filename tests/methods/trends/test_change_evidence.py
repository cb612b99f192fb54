"""Evidence for changes: against dense likelihoods, as a martingale, and against wrong drives."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

from tierod.core.errors import ParameterError
from tierod.methods.trends.change_evidence import RAMP, STEP, Changes, evidence, half_normal_ratio, right
from tierod.methods.trends.drive_filter import Prior, TrendNoise, filtered
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.fleet_alarms import alarm_level

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


def test_falling_levels_are_found_on_their_side_alone():
    drives = with_change(weekly(20, 16), np.where(np.arange(16) >= 8, -0.8, 0.0))
    usual = filtered(drives, PRIOR, NOISE)
    falling = evidence(drives, usual, Changes(0.5, 0.01, beginnings=16, side=-1.0))
    rising = evidence(drives, usual, Changes(0.5, 0.01, beginnings=16))
    assert (falling.logarithm[:, -1] > 15.0).all()
    assert (falling.size[:, -1] < 0.0).all()
    assert (rising.logarithm[:, -1] < 15.0).all()


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


def test_far_drives_that_agree_count_in_full():
    drives = with_change(weekly(40, 12), np.where(np.arange(12) >= 9, 1.0, 0.0))
    found = evidence(drives, filtered(drives, PRIOR, TrendNoise(0.0, 0.0, 0.1, 1e-6, 2.5)), Changes(0.5, 0.01))
    assert (found.logarithm[:, -1] > alarm_level(10_000.0)).mean() > 0.9
    assert found.size[:, -1].mean() == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize(("score", "information", "signature"), [(0.0, 0.0, 1.0), (3.0, 2.0, 0.7), (-2.0, 5.0, 1.3)])
def test_the_ratio_of_a_drive_has_a_mean_of_one_whether_drives_may_be_wrong_or_not(score, information, signature):
    wrong, deviation = 0.02, 0.8
    before = half_normal_ratio(np.array(score), np.array(information), np.array(deviation))

    def part(normal):
        after = half_normal_ratio(
            np.array(score + signature * normal), np.array(information + signature**2), np.array(deviation)
        )
        odds = right(np.array(normal), wrong)
        density = (1.0 - wrong) * stats.norm.pdf(normal) + wrong * stats.cauchy.pdf(normal, 0.0, 5.0)
        return float(density * np.exp(np.logaddexp(odds.wrong, odds.right + after - before)))

    near = integrate.quad(part, -30.0, 30.0, points=(0.0,), limit=400)[0]
    tails = integrate.quad(part, 30.0, np.inf)[0] + integrate.quad(part, -np.inf, -30.0)[0]
    assert near + tails == pytest.approx(1.0, abs=1e-6)


def test_the_half_normal_ratio_is_its_integral():
    part = lambda a: 2.0 * stats.norm.pdf(a, 0.0, 0.7) * math.exp(2.0 * a - 1.5 * a * a)  # noqa: E731
    expected = math.log(integrate.quad(part, 0.0, 10.0)[0])
    assert half_normal_ratio(np.array(2.0), np.array(3.0), np.array(0.7)) == pytest.approx(expected, rel=1e-9)


def test_bad_settings_are_refused():
    with pytest.raises(ParameterError, match="share of wrong drives is 0"):
        Changes(1.0, 0.01, wrong=0.0)
    with pytest.raises(ParameterError, match="must be positive"):
        Changes(0.0, 0.01)
    with pytest.raises(ParameterError, match="expected 1 for rising"):
        Changes(1.0, 0.01, side=0.5)
