"""Interacting models against an implementation by others, and where data are missing or far away."""

import dataclasses

import numpy as np
import pytest

from example_models import random_linear
from tierod.core.block import rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators.imm import ImmFilter
from tierod.methods.estimators.kalman import KalmanFilter

SWITCHING = ((0.95, 0.05), (0.2, 0.8))


def bank(noises=((0.1, 0.2, 0.3), (2.0, 2.0, 2.0))):
    system, model, parameters = random_linear(np.random.default_rng(0), 3, 1, 2)
    filters = tuple(KalmanFilter(model, parameters, (0.0,) * 3, (1.0,) * 3, noise, (0.5, 0.6)) for noise in noises)
    return system, ImmFilter(filters, SWITCHING, (0.6, 0.4))


def test_the_numbers_of_filterpy():
    filterpy = pytest.importorskip("filterpy.kalman")
    system, block = bank()
    filters = []
    for each in block.filters:
        peer = filterpy.KalmanFilter(3, 2, 1)
        peer.F, peer.B, peer.H = system.A, system.B, system.C
        peer.Q, peer.R, peer.P = np.diag(each.process_noise), np.diag(each.measurement_noise), np.eye(3)
        filters.append(peer)
    theirs = filterpy.IMMEstimator(filters, np.array(block.initial_probabilities), np.array(SWITCHING))
    samples, expected = np.random.default_rng(1).normal(size=(60, 3)), []
    for row in samples:
        theirs.predict(row[:1, None])
        theirs.update((row[1:] - system.D @ row[:1])[:, None])
        expected.append([*theirs.x[:, 0], *np.diag(theirs.P), *theirs.mu])
    found = scan(block, samples)
    names = [*(f"mean.x{k}" for k in range(3)), *(f"variance.x{k}" for k in range(3)), *_shares]
    np.testing.assert_allclose(np.column_stack([found[name] for name in names]), expected, rtol=1e-9)


_shares = ("probabilities.0", "probabilities.1")


def test_alike_filters_are_one_filter():
    _, block = bank(noises=((0.1, 0.2, 0.3),) * 2)
    samples = np.random.default_rng(2).normal(size=(40, 3))
    both, single = scan(block, samples), scan(block.filters[0], samples)
    for name in single.names:
        np.testing.assert_allclose(both[name], single[name], rtol=1e-9, err_msg=name)


def test_an_innovation_beyond_all_likelihood_leaves_probabilities():
    _, block = bank()
    samples = np.zeros((3, 3))
    samples[1, 1:] = 1e6
    found = scan(block, samples)
    shares = np.column_stack([found[name] for name in _shares])
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    assert np.isfinite(found.values[:, :3]).all()
    assert shares[1, 1] > 0.99  # the model with more noise explains it better


def test_what_is_missing_says_nothing():
    _, block = bank()
    state = block.init()
    sample = rebuild(skeleton(block.Sample), [0.3, np.nan, np.nan])
    after, estimate = block.step(state, sample)
    expected = np.array(block.initial_probabilities) @ np.array(SWITCHING)
    np.testing.assert_allclose(after.probabilities, expected)
    assert estimate.present == estimate.nis == 0.0
    held, estimate = block.step(after, rebuild(sample, [np.nan, 1.0, 1.0]))
    assert held.probabilities == after.probabilities
    assert [belief.mean for belief in held.beliefs] == [belief.mean for belief in after.beliefs]
    assert held.beliefs[0].covariance[0] > after.beliefs[0].covariance[0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"switching": ((1.0, 0.0), (0.5, 0.5))}, "lost for good"),
        ({"switching": ((0.5, 0.5),)}, "expected 2 rows of 2"),
        ({"initial_probabilities": (0.5, 0.6)}, "sum is 1"),
    ],
)
def test_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        dataclasses.replace(bank()[1], **change)


def test_filters_of_other_models_are_refused():
    _, one = bank()
    _, model, parameters = random_linear(np.random.default_rng(0), 2, 1, 2)
    small = KalmanFilter(model, parameters, (0.0,) * 2, (1.0,) * 2, (0.1, 0.1), (0.5, 0.6))
    with pytest.raises(ParameterError, match="share one state"):
        ImmFilter((one.filters[0], small), SWITCHING, (0.5, 0.5))
    with pytest.raises(ParameterError, match="no masks and no gate"):
        ImmFilter((one.filters[0], dataclasses.replace(one.filters[1], gate=10.0)), SWITCHING, (0.5, 0.5))
