"""Corrections by readings that may be left out, against the joint update and the density of a normal distribution."""

import math

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tierod.methods.estimators.kernels import correct
from tierod.methods.estimators.linear_algebra import pack, unpack
from tierod.monitors.condition.filter_updates import logarithm, spread_of, update

CHANCE = np.random.default_rng(4)
ROOT = CHANCE.normal(size=(4, 4))
COVARIANCE = ROOT @ ROOT.T
ROWS = CHANCE.normal(size=(3, 4))
NOISE = (0.5, 0.2, 1.5)
INNOVATIONS = (0.7, -1.1, 0.4)
FAR = 1e3


def corrected(innovations=INNOVATIONS, used=(1.0, 1.0, 1.0), influence=FAR):
    return update(pack(COVARIANCE.tolist()), ROWS.tolist(), innovations, NOISE, NOISE, used, influence)


def test_it_is_the_joint_update():
    ours = corrected()
    theirs = correct(pack(COVARIANCE.tolist()), ROWS.tolist(), INNOVATIONS, NOISE)
    np.testing.assert_allclose(ours.shift, theirs.shift, rtol=1e-12)
    np.testing.assert_allclose(ours.covariance, theirs.covariance, rtol=1e-12, atol=1e-15)
    assert sum(value * value for value in ours.whitened) == pytest.approx(theirs.nis)


def test_whitened_innovations_make_the_density_of_all_readings():
    ours = corrected()
    spread = ROWS @ COVARIANCE @ ROWS.T + np.diag(NOISE)
    logs = sum(math.log(2.0 * math.pi * each) + math.log(wide) for each, wide in zip(NOISE, ours.widening, strict=True))
    density = -0.5 * (sum(value * value for value in ours.whitened) + logs)
    assert density == pytest.approx(multivariate_normal.logpdf(INNOVATIONS, cov=spread))


@pytest.mark.parametrize("lost", [math.nan, 1e9])
def test_what_is_not_used_changes_nothing_whatever_it_reads(lost):
    left_out = corrected((INNOVATIONS[0], lost, INNOVATIONS[2]), used=(1.0, 0.0, 1.0))
    without = update(
        pack(COVARIANCE.tolist()), ROWS[[0, 2]].tolist(), INNOVATIONS[::2], NOISE[::2], NOISE[::2], (1.0, 1.0), FAR
    )
    np.testing.assert_allclose(left_out.shift, without.shift)
    np.testing.assert_allclose(left_out.covariance, without.covariance)
    assert left_out.whitened[1] == 0.0
    assert left_out.widening[1] == 1.0


def test_an_odd_reading_moves_the_mean_no_further_than_its_influence():
    far, farther = (corrected((size, 0.0, 0.0), used=(1.0, 0.0, 0.0), influence=3.0) for size in (1e3, 1e4))
    np.testing.assert_allclose(far.shift, farther.shift)
    variance = ROWS[0] @ COVARIANCE @ ROWS[0] + NOISE[0]
    np.testing.assert_allclose(far.shift, 3.0 * COVARIANCE @ ROWS[0] / math.sqrt(variance))
    assert farther.whitened[0] == pytest.approx(10.0 * far.whitened[0])


def test_the_spread_of_a_reading():
    assert spread_of(pack(COVARIANCE.tolist()), ROWS[0].tolist()) == pytest.approx(ROWS[0] @ COVARIANCE @ ROWS[0])
    assert np.array(unpack(pack(COVARIANCE.tolist()))) == pytest.approx(COVARIANCE)


@pytest.mark.parametrize("value", [1e-6, 0.3, 1.0, 2.0, 1e3, 1e6])
def test_the_logarithm_is_one(value):
    assert logarithm(value) == pytest.approx(math.log(value), abs=1e-8)


def test_the_logarithm_of_a_very_large_number_is_good_to_a_thousandth():
    assert logarithm(1e20) == pytest.approx(math.log(1e20), abs=1e-3)
