"""Scatter between drives: what was drawn is found, outliers or not."""

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.methods.trends.drive_scatter import drive_scatter
from tierod.methods.trends.drives import Drives


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


def test_alike_deviations_are_taken_as_they_are_or_smaller():
    larger = drive_scatter(fleet((0.1, 0.1001), 1.0, 0.2))
    assert not larger.separated
    assert larger.scale == 1.0
    assert larger.scatter == pytest.approx(0.2, rel=0.08)
    smaller = drive_scatter(fleet((0.1, 0.1001), 0.3, 0.0))
    assert smaller.scatter == 0.0
    assert smaller.scale == pytest.approx(0.3, rel=0.08)


def test_effects_that_differ_from_car_to_car_are_found():
    alike, differing = (drive_scatter(fleet((0.1, 0.1001), 1.0, 0.0, differing=size)).differing for size in (0.0, 0.01))
    assert alike[0] < 0.004  # what so few drives cannot exclude
    assert differing[0] == pytest.approx(0.01, rel=0.3)


def test_too_few_drives_are_refused():
    with pytest.raises(InputError, match="learnt from 30 or more"):
        drive_scatter(fleet((0.1, 0.2), 1.0, 0.1, cars=1, count=20))
