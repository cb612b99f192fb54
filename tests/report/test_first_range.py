import numpy as np
import pytest

from tierod.report.charts.figure import first_range


def test_what_has_both_signs_is_shown_whole():
    mean = np.array([np.nan, -3.0, -1.0, 0.0, 2.0, 5.0])
    low, high = first_range(mean, mean, mean + 100.0, [])
    assert (low, high) == pytest.approx((-3.64, 5.64))


def test_levels_are_within():
    mean = np.array([-1.0, 1.0])
    assert first_range(mean, mean, mean, [4.0])[1] > 4.0


def test_a_slip_below_zero_and_a_wide_start_make_no_range():
    mean = np.full(1000, 4.0)
    mean[:5] = -0.5
    outer = mean + np.where(np.arange(1000) < 10, 50.0, 1.0)
    low, high = first_range(mean, mean, outer, [])
    assert low == 0.0
    assert 4.0 < high < 8.0


def test_nothing_known_still_gives_a_range():
    empty = np.full(4, np.nan)
    low, high = first_range(empty, empty, empty, [])
    assert low < high
