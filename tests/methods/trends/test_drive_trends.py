"""Filter and scatter over the drives of a fleet: what was drawn is found."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.methods.trends.drive_filter import Drives, Prior, TrendNoise, filtered, smoothed
from tierod.methods.trends.drive_scatter import drive_scatter, wandering

NOISE = TrendNoise(level_walk=0.02, slope_walk=0.001, scatter=0.1, scale=0.5, clip=1e9)
PRIOR = Prior(np.array([4.0, 0.001, -0.02]), np.diag([0.3**2, 0.002**2, 0.01**2]))


def drawn(seed=1, cars=3, count=9):
    chance = np.random.default_rng(seed)
    day = np.cumsum(chance.uniform(1.0, 9.0, (cars, count)), axis=1)
    warm = chance.normal(0.0, 8.0, (cars, count, 1))
    estimate = 4.0 + 0.3 * chance.standard_normal((cars, count))
    estimate[1:2, 4] = np.nan  # a drive that gave no estimate
    estimate[2:3, 6:] = np.nan  # a car with fewer drives
    return Drives(day, estimate, chance.uniform(0.1, 0.3, (cars, count)), warm)


def dense(drives, car):
    """Mean and covariance of level and slope at each drive from all drives of a car, by the joint normal distribution.

    The state's values at the drives are stacked; walks are white noise integrated exactly on a fine grid of days.
    """
    there = np.flatnonzero(drives.present[car])
    day, order = drives.day[car, there], len(PRIOR.mean)
    count = len(there)
    mean, big = np.zeros((count, order)), np.zeros((count, order, count, order))
    forward = [np.eye(order)]
    spread = [PRIOR.covariance]
    for k in range(1, count):
        gap = day[k] - day[k - 1]
        step = np.eye(order)
        step[0, 1] = gap
        noise = np.zeros((order, order))
        steps = 4000  # the integral of F q F' by the middle rule
        for s in (np.arange(steps) + 0.5) * gap / steps:
            reach = np.array([s, 1.0, 0.0])
            noise += np.outer(reach, reach) * NOISE.slope_walk**2 * gap / steps
        noise[0, 0] += NOISE.level_walk**2 * gap
        forward.append(step)
        spread.append(step @ spread[-1] @ step.T + noise)
    for k in range(count):
        mean[k] = PRIOR.mean if k == 0 else forward[k] @ mean[k - 1]
        big[k, :, k, :] = spread[k]
        carried = spread[k]
        for later in range(k + 1, count):
            carried = forward[later] @ carried
            big[later, :, k, :] = carried
            big[k, :, later, :] = carried.T
    covariance = big.reshape(count * order, count * order)
    rows = np.zeros((count, count * order))
    for k, at in enumerate(there):
        rows[k, k * order], rows[k, k * order + 2] = 1.0, drives.regressors[car, at, 0]
    error = np.diag(NOISE.variance(drives.deviation[car, there]))
    gain = covariance @ rows.T @ np.linalg.inv(rows @ covariance @ rows.T + error)
    updated = mean.ravel() + gain @ (drives.estimate[car, there] - rows @ mean.ravel())
    left = covariance - gain @ rows @ covariance
    return there, updated.reshape(count, order), left.reshape(count, order, count, order)


@pytest.mark.parametrize("car", [0, 1, 2])
def test_filter_and_smoother_agree_with_dense_regression(car):
    drives = drawn()
    found = filtered(drives, PRIOR, NOISE)
    mean, covariance = smoothed(found, NOISE)
    there, expected, spread = dense(drives, car)
    np.testing.assert_allclose(found.mean[car, there[-1]], expected[-1], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.covariance[car, there[-1]], spread[-1, :, -1, :], rtol=1e-5, atol=1e-12)
    for place, k in enumerate(there):
        np.testing.assert_allclose(mean[car, k], expected[place], rtol=1e-4, atol=1e-7)
        np.testing.assert_allclose(covariance[car, k], spread[place, :, place, :], rtol=1e-3, atol=1e-9)


def test_a_wrong_drive_moves_the_level_by_a_bounded_amount():
    drives = drawn(cars=1, count=6)
    clipped = TrendNoise(0.02, 0.0, 0.1, 0.5, clip=2.5)
    estimate = drives.estimate.copy()
    levels = []
    for wrong in (6.0, 60.0):
        estimate[0, -1] = wrong
        changed = Drives(drives.day, estimate, drives.deviation, drives.regressors)
        levels.append(filtered(changed, PRIOR, clipped).mean[0, -1, 0])
    assert levels[0] == pytest.approx(levels[1], abs=1e-12)
    assert levels[0] > filtered(drives, PRIOR, clipped).mean[0, -2, 0]


def drives(estimate):
    estimate = np.atleast_2d(np.array(estimate, float))
    day = np.tile(np.arange(estimate.shape[1], dtype=float), (len(estimate), 1))
    return Drives(day, estimate, np.full(day.shape, 1e-6), np.full((*day.shape, 1), np.nan))


def fleet(stated, scale, scatter, wrong=0.0, cars=300, count=20, seed=2, differing=0.0):
    chance = np.random.default_rng(seed)
    day = 7.0 * np.tile(np.arange(count), (cars, 1)).astype(float)
    deviation = chance.uniform(*stated, day.shape)
    warm = chance.normal(0.0, 10.0, day.shape)
    error = np.hypot(scale * deviation, scatter) * chance.standard_normal(day.shape)
    error *= np.where(chance.random(day.shape) < wrong, 5.0, 1.0)
    level = 4.0 + chance.standard_normal((cars, 1))
    estimate = level + (differing * chance.standard_normal((cars, 1)) - 0.02) * warm + error
    return Drives(day, estimate, deviation, warm[..., None])


@pytest.mark.parametrize("wrong", [0.0, 0.03])
def test_scale_scatter_and_share_are_found(wrong):
    found = drive_scatter(fleet((0.05, 0.4), 0.6, 0.1, wrong))
    assert found.separated
    assert found.scale == pytest.approx(0.6, rel=0.1)
    assert found.scatter == pytest.approx(0.1, rel=0.12)
    assert found.wrong_share == pytest.approx(wrong, abs=0.004)
    assert found.effects[0] == pytest.approx(-0.02, rel=0.05)


def wandering_fleet(walk, slopes, faulty=0, cars=400, count=60):
    chance = np.random.default_rng(6)
    day = 7.0 * np.tile(np.arange(count), (cars, 1)).astype(float)
    level = np.cumsum(walk * np.sqrt(7.0) * chance.standard_normal(day.shape), axis=1)
    slope = slopes[0] + slopes[1] * chance.standard_normal((cars, 1))
    slope[:faulty] = 0.01
    estimate = 4.0 + level + slope * day + 0.1 * chance.standard_normal(day.shape)
    return Drives(day, estimate, np.full(day.shape, 0.1), np.zeros((*day.shape, 0)))


@pytest.mark.parametrize("faulty", [0, 12])
def test_the_walk_is_found(faulty):
    found = wandering(wandering_fleet(0.02, (0.0, 0.0), faulty), np.zeros(0))
    assert found.level_walk == pytest.approx(0.02, rel=0.2)
    assert found.slope == pytest.approx(0.0, abs=2e-4)
    assert found.longest == 7.0 * 16  # the next distance is longer than half a year
