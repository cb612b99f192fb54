"""Wrong first drives are left out; later ones and those of cars with few drives are not."""

import numpy as np

from tierod.methods.trends.drive_filter import FIRST, TrendNoise, with_right_first
from tierod.methods.trends.drives import Drives

NOISE = TrendNoise(0.0, 0.0, 0.1)


def drives(estimate):
    estimate = np.atleast_2d(np.array(estimate, float))
    day = np.tile(np.arange(estimate.shape[1], dtype=float), (len(estimate), 1))
    return Drives(day, estimate, np.full(day.shape, 1e-6), np.full((*day.shape, 1), np.nan))


def test_a_wrong_first_drive_is_left_out():
    found = with_right_first(drives([3.0, 4.0, 4.1, 3.9, 4.0, 4.0, 9.0]), NOISE, np.zeros(1))
    np.testing.assert_array_equal(np.isnan(found.estimate[0]), [True] + [False] * 6)


def test_a_car_with_few_drives_keeps_them_all():
    few = drives([3.0, 4.0, 4.1] + [np.nan] * FIRST)
    np.testing.assert_array_equal(with_right_first(few, NOISE, np.zeros(1)).estimate, few.estimate)


def test_what_a_regressor_explains_is_not_wrong():
    warm = drives([3.0, 4.0, 4.1, 3.9, 4.0])
    warm = Drives(warm.day, warm.estimate, warm.deviation, np.array([[[10.0], [0.0], [0.0], [0.0], [0.0]]]))
    assert np.isfinite(with_right_first(warm, NOISE, np.array([-0.1])).estimate).all()
