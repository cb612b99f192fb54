"""Fits of faulty readings against closed forms."""

import numpy as np
import pytest

from tierod.monitors.condition.kinds import Fit, SlopeFit, fitted, lowest, sloped


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


def test_the_lowest_point_of_a_parabola_is_found_where_it_is():
    places = (0.19, 0.24, 0.3)
    place, value, width = lowest(places, [3.0 + 400.0 * (each - 0.23) ** 2 for each in places])
    assert (place, value) == (pytest.approx(0.23), pytest.approx(3.0))
    assert width == pytest.approx(min((2.0 / 800.0) ** 0.5, 0.11))
