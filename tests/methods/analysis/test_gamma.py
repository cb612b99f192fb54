"""Quantiles of the gamma distribution, held against SciPy's."""

import pytest

from tierod.methods.analysis.consistency import MOST_SHAPE, gamma_quantile, lower_gamma

special = pytest.importorskip("scipy.special")
PROBABILITIES = (0.001, 0.025, 0.5, 0.95, 0.975, 0.999)


@pytest.mark.parametrize("shape", [0.5, 1.0, 1.5, 3.0, 37.5, 1e3, 17_999.0, 360_000.5, 999_999.0])
@pytest.mark.parametrize("probability", PROBABILITIES)
def test_quantile_is_that_of_scipy(shape, probability):
    assert gamma_quantile(shape, probability) == pytest.approx(special.gammaincinv(shape, probability), rel=1e-11)


@pytest.mark.parametrize("probability", PROBABILITIES)
def test_quantile_of_a_shape_beyond_the_series(probability):
    shape = 4.0 * MOST_SHAPE
    assert gamma_quantile(shape, probability) == pytest.approx(special.gammaincinv(shape, probability), rel=1e-9)


@pytest.mark.parametrize(("shape", "x"), [(0.5, 0.0), (0.5, 0.1), (3.0, 2.0), (3.0, 9.0), (500.0, 510.0), (2.0, 1e-9)])
def test_incomplete_gamma_is_that_of_scipy(shape, x):
    assert lower_gamma(shape, x) == pytest.approx(special.gammainc(shape, x), rel=1e-12)


@pytest.mark.parametrize(
    ("shape", "probability"), [(0.0, 0.5), (-1.0, 0.5), (1.0, 0.0), (1.0, 1.0), (float("nan"), 0.5)]
)
def test_what_no_distribution_has_is_refused(shape, probability):
    with pytest.raises(ValueError, match="expected > 0"):
        gamma_quantile(shape, probability)
