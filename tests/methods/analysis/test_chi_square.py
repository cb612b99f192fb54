import math

import numpy as np
import pytest
from scipy import stats

from tierod.methods.analysis.chi_square import chi_square_quantile, mean_band, normalised_error_squared


def test_errors_with_full_covariance_and_with_variances_alone():
    rng = np.random.default_rng(2)
    root = rng.normal(size=(3, 3))
    P = root @ root.T + np.eye(3)
    error = rng.multivariate_normal(np.zeros(3), P, size=50)
    packed = np.tile(P[np.triu_indices(3)], (50, 1))
    expected = [e @ np.linalg.inv(P) @ e for e in error]
    np.testing.assert_allclose(normalised_error_squared(error, packed), expected)
    variances = np.tile(np.diag(P), (50, 1))
    np.testing.assert_allclose(normalised_error_squared(error, variances), (error**2 / variances).sum(axis=1))
    packed[0, 0], packed[1, 0], error[2, 0] = np.nan, -1.0, np.nan
    assert np.isnan(normalised_error_squared(error, packed)[:3]).all()


def test_chi_square_is_that_of_scipy_stats():
    for degrees in (1, 2, 50, 3_000_000):
        assert chi_square_quantile(0.975, degrees) == pytest.approx(stats.chi2.ppf(0.975, degrees), rel=1e-9)
    assert mean_band(100) == pytest.approx(np.array(stats.chi2.interval(0.95, 100)) / 100)


def test_nothing_has_no_band():
    assert all(map(math.isnan, mean_band(0)))
