"""Fits of faulty readings against closed forms."""

import numpy as np
import pytest

from tierod.monitors.condition.kinds import (
    DELAYS,
    DENSE,
    Fit,
    SlopeFit,
    between,
    delays_of,
    fitted,
    likeliest,
    log_density,
    lowest,
    sloped,
)


def test_the_product_of_the_densities_is_that_of_all_readings_together():
    """The same as one normal density whose covariance holds the parameter's own variance."""
    chance = np.random.default_rng(1)
    rows, readings, square, before = chance.normal(size=5), chance.normal(size=5), 0.3, 2.0
    fit = Fit(1.0, before, 0.0)
    for reading, row in zip(readings, rows, strict=True):
        fit = fitted(fit, reading, row, square, 1.0, 1.0)
    covariance = before * np.outer(rows, rows) + square * np.eye(5)
    off = readings - rows
    whole = -0.5 * (off @ np.linalg.solve(covariance, off) + np.linalg.slogdet(2.0 * np.pi * covariance)[1])
    assert fit.score == pytest.approx(whole)
    information = 1.0 / before + rows @ rows / square
    assert fit.variance == pytest.approx(1.0 / information)
    assert fit.value == pytest.approx((1.0 / before + rows @ readings / square) / information)


def test_a_slope_is_that_of_least_squares_with_what_is_known_before():
    chance = np.random.default_rng(2)
    times, off, square = np.arange(8) * 0.1, chance.normal(size=8), 0.2
    fit = SlopeFit(0.0, 0.0, 0.5, 0.0, 4.0, 0.0)
    for time, each in zip(times, off, strict=True):
        fit = sloped(fit, each, time, square, 1.0, 1.0)
    rows = np.column_stack([np.ones(8), times])
    inverse = np.linalg.inv(np.diag([1.0 / 0.5, 1.0 / 4.0]) + rows.T @ rows / square)
    np.testing.assert_allclose([fit.start, fit.slope], inverse @ rows.T @ off / square)
    np.testing.assert_allclose([fit.start_variance, fit.covariance, fit.slope_variance], inverse[[0, 0, 1], [0, 1, 1]])


def test_a_share_of_a_reading_counts_for_that_share():
    assert log_density(0.7, 2.0, 0.1) == pytest.approx(-0.05 * (0.49 / 2.0 + np.log(4.0 * np.pi)))


def test_the_lowest_point_of_a_parabola_is_found_where_it_is():
    places = (0.19, 0.24, 0.3)
    place, value, width = lowest(places, [3.0 + 400.0 * (each - 0.23) ** 2 for each in places])
    assert (place, value) == (pytest.approx(0.23), pytest.approx(3.0))
    assert width == pytest.approx(min((2.0 / 800.0) ** 0.5, 0.11))


def test_nothing_is_lower_than_nothing_and_no_place_beyond_the_outer_ones():
    assert lowest((1.0, 2.0, 3.0), (9.0, 1.0, 1.5))[1] >= 0.0
    assert lowest((1.0, 2.0, 3.0), (5.0, 5.0, 5.0))[0] == 2.0
    assert lowest((1.0, 2.0, 3.0), (3.0, 2.0, 1.0))[0] == 3.0


@pytest.mark.parametrize("place", [1.0, 1.5, 2.0, 3.5, 4.0])
def test_between_goes_by_straight_lines(place):
    values = (5.0, 7.0, 4.0)
    assert between(place, (1.0, 2.0, 4.0), values) == pytest.approx(np.interp(place, (1.0, 2.0, 4.0), values))


def test_delays_are_whole_samples_each_once_and_dense_where_the_signal_jumps():
    assert delays_of(False, 0.01) == tuple(round(100.0 * each) for each in DELAYS)
    assert len(delays_of(True, 0.01)) == len(DENSE)
    slow = delays_of(False, 0.05)
    assert slow[0] >= 1
    assert list(slow) == sorted(set(slow))


def test_the_likeliest_that_may_be_named_is_and_the_mildest_effect_in_doubt_counts():
    options = (
        (2.0, 1.0, -30.0, 0.0, 0.0, 0.5),
        (3.0, 1.0, -20.0, 1.1, 0.2, 4.0),
        (5.0, 0.0, -10.0, 1.2, 0.3, 3.0),
        (8.0, 1.0, -24.0, 1.3, 0.4, -2.0),
    )
    assert likeliest(options, 6.0) == (3.0, 1.1, 0.2, -2.0)
    assert likeliest(options, 2.0) == (3.0, 1.1, 0.2, 4.0)
    assert likeliest(options, 20.0) == (3.0, 1.1, 0.2, 0.5)


def test_a_reading_that_is_all_but_impossible_counts_no_more_than_one_of_eight_deviations():
    assert log_density(1e6, 4.0, 0.1) == pytest.approx(log_density(16.0, 4.0, 0.1))
    assert log_density(15.0, 4.0, 0.1) > log_density(16.0, 4.0, 0.1)
