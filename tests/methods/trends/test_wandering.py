"""Walks and slopes of a fleet: what was drawn is found, a few faulty cars or not."""

import numpy as np
import pytest

from tierod.methods.trends.drive_scatter import wandering
from tierod.methods.trends.drives import Drives


def fleet(walk, slopes, faulty=0, cars=400, count=60):
    chance = np.random.default_rng(6)
    day = 7.0 * np.tile(np.arange(count), (cars, 1)).astype(float)
    level = np.cumsum(walk * np.sqrt(7.0) * chance.standard_normal(day.shape), axis=1)
    slope = slopes[0] + slopes[1] * chance.standard_normal((cars, 1))
    slope[:faulty] = 0.01
    estimate = 4.0 + level + slope * day + 0.1 * chance.standard_normal(day.shape)
    return Drives(day, estimate, np.full(day.shape, 0.1), np.zeros((*day.shape, 0)))


@pytest.mark.parametrize("faulty", [0, 12])
def test_the_walk_is_found(faulty):
    found = wandering(fleet(0.02, (0.0, 0.0), faulty), np.zeros(0))
    assert found.level_walk == pytest.approx(0.02, rel=0.2)
    assert found.slope == pytest.approx(0.0, abs=2e-4)
    assert found.longest == 7.0 * 16  # the next distance is longer than half a year


def test_slopes_are_found():
    found = wandering(fleet(0.0, (0.001, 0.002)), np.zeros(0))
    assert found.slope == pytest.approx(0.001, abs=2e-4)
    assert found.slope_deviation == pytest.approx(0.002, rel=0.2)
    assert found.level_walk < 0.01


def test_what_few_cars_cannot_exclude_counts_as_walk_and_slope():
    few, many = (wandering(fleet(0.0, (0.0, 0.0), cars=cars), np.zeros(0)) for cars in (5, 500))
    assert few.level_walk > 2.0 * many.level_walk > 0.0
    assert few.slope_deviation > 2.0 * many.slope_deviation > 0.0


def test_a_few_drives_identify_nothing():
    assert wandering(fleet(0.02, (0.0, 0.0), cars=20, count=3), np.zeros(0)).longest == 0.0
