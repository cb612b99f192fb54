"""Shifts that fault-free levels make: the statistic keeps its mean, and tyres raise no alarm."""

import math

import numpy as np
import pytest
from scipy import integrate, stats

from tierod.methods.trends.change_evidence import Changes, evidence
from tierod.methods.trends.drive_filter import Prior, TrendNoise, filtered
from tierod.methods.trends.drives import Drives
from tierod.methods.trends.fleet_alarms import EVERY, alarm_level, normal_ratio

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
