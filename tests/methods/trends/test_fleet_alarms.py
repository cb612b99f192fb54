"""Alarms of a fleet: bounds and lists."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, stats

from tierod.core.errors import ParameterError
from tierod.methods.trends.change_evidence import Changes, evidence
from tierod.methods.trends.drive_filter import Prior, TrendNoise, filtered
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.fleet_alarms import (
    EVERY,
    alarm_level,
    chance_by,
    log_e_values,
    normal_ratio,
    selected,
    time_to_limit,
)


def test_the_level_is_the_time_between_false_alarms():
    assert alarm_level(10_000.0) == pytest.approx(math.log(3_652_500.0))
    with pytest.raises(ParameterError, match="expected a positive number"):
        alarm_level(0.0)


def test_e_values_of_cars_without_a_change_have_a_mean_of_one():
    # the statistic in days has the time watched as its mean
    watched = np.array([0.0, 100.0, 5000.0])
    with np.errstate(divide="ignore"):
        e = np.exp(log_e_values(np.log(watched), watched, 3650.0))
    np.testing.assert_allclose(e, 1.0)


def test_the_list_keeps_its_share_of_wrong_cars():
    chance = np.random.default_rng(4)
    shares = []
    for _ in range(400):
        changed = np.arange(200) < 20
        z = chance.standard_normal(200) + np.where(changed, 4.0, 0.0)
        chosen = selected(3.0 * z - 4.5, 0.1)
        shares.append((chosen & ~changed).sum() / max(chosen.sum(), 1))
    assert np.mean(shares) <= 0.1
    assert selected(np.array([0.0, 0.0]), 0.1).sum() == 0
    assert selected(np.log([25.0, 12.0, 1.0]), 0.2).tolist() == [True, True, False][:3]


def test_a_share_outside_its_range_is_refused():
    with pytest.raises(ParameterError, match="false-discovery rate is 1"):
        selected(np.zeros(3), 1)


LEVEL = np.array([[5.0, 0.01], [5.0, 0.0], [8.0, 0.0]])
SPREAD = np.array([[[0.01, -1e-5], [-1e-5, 4e-6]], [[0.01, 0.0], [0.0, 1e-12]], [[0.01, 0.0], [0.0, 1e-12]]])
LIMIT = np.full(3, 7.5)


def test_quantiles_are_those_of_drawn_trends():
    drawn = np.random.default_rng(0).multivariate_normal(LEVEL[0], SPREAD[0], 400_000)
    for share in (0.05, 0.5, 0.9):
        at = time_to_limit(LEVEL, SPREAD, LIMIT, share)[0]
        assert np.mean(drawn[:, 0] + at * drawn[:, 1] >= 7.5) == pytest.approx(share, abs=0.003)
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.5)[0] == pytest.approx(250.0)


def test_no_trend_never_and_beyond_the_limit_now():
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.05)[1] == np.inf
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.5)[2] == 0.0
    assert chance_by(LEVEL, SPREAD, LIMIT, np.zeros(3))[2] > 0.99


NOISE = TrendNoise(level_walk=0.0, slope_walk=0.0, scatter=0.1, scale=1e-6, clip=1e9)
PRIOR = Prior(np.array([4.0, 0.0]), np.diag([0.3**2, 1e-5**2]))


def fleet(cars, count, gap, shift):
    """Cars whose level moves as the function `shift(generator, days)` gives it."""
    chance = np.random.default_rng(11)
    day = gap * np.tile(np.arange(count), (cars, 1)).astype(float)
    level = 4.0 + 0.3 * chance.standard_normal((cars, 1)) + shift(chance, day)
    return Drives(
        day, level + 0.1 * chance.standard_normal(day.shape), np.full(day.shape, 0.1), np.zeros((*day.shape, 0))
    )


def statistic(drives, deviation):
    changes = Changes(step=0.06, ramp=0.003, shift=deviation, wrong=1e-12, beginnings=8)
    return evidence(drives, filtered(drives, PRIOR, NOISE), changes).logarithm


def test_with_shifts_of_fault_free_cars_the_mean_is_the_time_watched():
    def shifts(chance, day):
        at = chance.exponential(EVERY, (len(day), 1))
        return np.where(day > at, 0.2 * chance.standard_normal((len(day), 1)), 0.0)

    drives = fleet(40_000, 5, 7.0, shifts)
    known, ignored = (np.exp(statistic(drives, deviation))[:, 4] for deviation in (0.2, 0.0))
    error = known.std() / math.sqrt(len(known))
    assert known.mean() == pytest.approx(28.0, abs=4.0 * error)
    assert ignored.mean() > 28.0 + 10.0 * error


def test_tyres_raise_no_alarm_and_larger_changes_do():
    def changed(size):
        return fleet(20, 60, 1.0, lambda chance, day: np.where(day >= 40.0, size, 0.0))

    def highest(size, shift):
        changes = Changes(step=2.0, ramp=0.02, shift=shift)
        return evidence(changed(size), filtered(changed(size), PRIOR, NOISE), changes).logarithm.max(axis=1)

    level = alarm_level(10_000.0)
    assert (highest(0.2, 0.0) > level).mean() > 0.8
    assert (highest(0.2, 0.06) < level).all()
    assert (highest(1.0, 0.06) > level).all()


def test_the_normal_ratio_is_its_integral():
    def part(a):
        return stats.norm.pdf(a, 0.0, 0.7) * math.exp(2.0 * a - 1.5 * a * a)

    expected = math.log(integrate.quad(part, -10.0, 10.0)[0])
    assert normal_ratio(np.array(2.0), np.array(3.0), 0.7) == pytest.approx(expected, rel=1e-9)
    assert normal_ratio(np.array(2.0), np.array(3.0), 0.0) == 0.0
