"""Modulating functions: derivatives of polynomials and noise."""

import numpy as np
import pytest

from tierod.methods.identification.regression import Modulation

WINDOW = Modulation(20, 5, 0.01)
TIME = np.arange(200) * 0.01


def test_a_parabola_has_its_derivatives():
    values = 3.0 + 2.0 * TIME - 4.0 * TIME**2
    middle = WINDOW.mean(TIME)
    assert np.allclose(WINDOW.rate(values), 2.0 - 8.0 * middle, rtol=1e-4, atol=1e-3)
    assert np.allclose(WINDOW.acceleration(values), -8.0, rtol=1e-4, atol=1e-3)
    assert np.allclose(WINDOW.mean(np.full(200, 3.0)), 3.0)


def test_growth_is_the_mean_of_what_happens_between_samples():
    slopes = np.random.default_rng(1).normal(size=199)
    values = np.concatenate([[0.0], np.cumsum(slopes * 0.01)])
    assert np.allclose(WINDOW.growth(values), WINDOW.between(slopes), atol=1e-12)


def test_a_missing_sample_touches_only_its_windows():
    values = TIME.copy()
    values[100] = np.nan
    rows = WINDOW.mean(values)
    starts = np.arange(len(rows)) * WINDOW.stride
    touched = (starts <= 100) & (starts + WINDOW.length >= 100)
    assert np.array_equal(np.isnan(rows), touched)


def test_gain_is_that_of_white_noise():
    noise = np.random.default_rng(2).normal(size=200_001)
    fine = Modulation(20, 1, 0.01)
    mean, growth = fine.gain
    assert np.std(fine.between(noise[1:])) == pytest.approx(mean, rel=0.03)
    assert np.std(fine.growth(noise)) == pytest.approx(growth, rel=0.03)
