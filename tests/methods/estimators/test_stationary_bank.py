"""A bank with stationary gains: one filter is the stationary filter; more are a slow loop in NumPy."""

import numpy as np
import pytest

from example_models import random_linear
from tierod.core.block import rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators.riccati import stationary_gain
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod_lab.methods.stationary import StationaryFilter

SWITCHING = np.array([[0.97, 0.03], [0.1, 0.9]])
NOISES = ((0.1, 0.2, 0.3), (2.0, 2.0, 2.0))
R = (0.5, 0.6)


def made(noises=NOISES, switching=SWITCHING):
    system, model, parameters = random_linear(np.random.default_rng(0), 3, 1, 2)
    rows = tuple(map(tuple, np.atleast_2d(switching).tolist()))
    return system, StationaryBank.design(system, model, parameters, noises, R, rows)


def slow(system, samples):
    gains = [stationary_gain(system, noise, R) for noise in NOISES]
    means, shares, out = np.zeros((2, 3)), np.full(2, 0.5), []
    for row in samples:
        prior = shares @ SWITCHING
        weights = SWITCHING * shares[:, None] / prior
        mixed = weights.T @ means
        likelihoods = np.zeros(2)
        for j, gain in enumerate(gains):
            ahead = system.A @ mixed[j] + system.B @ row[:1]
            innovation = row[1:] - system.D @ row[:1] - system.C @ ahead
            means[j] = ahead + gain.filter @ innovation
            S = gain.innovation_covariance
            likelihoods[j] = np.exp(-0.5 * innovation @ np.linalg.solve(S, innovation)) / np.sqrt(np.linalg.det(S))
        shares = prior * likelihoods
        shares /= shares.sum()
        out.append([*(shares @ means), *shares])
    return np.array(out)


def test_one_noise_is_the_stationary_filter():
    system, block = made(NOISES[:1], [[1.0]])
    single = StationaryFilter.design(block.model, block.parameters, NOISES[0], R, (0.0,) * 3, (0.0,))
    samples = np.random.default_rng(1).normal(size=(50, 3))
    samples[10:13, 1] = np.nan
    found, expected = scan(block, samples), scan(single, samples)
    for name in ("mean.x0", "mean.x1", "mean.x2", "variance.x0", "innovation.y0", "present"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(found["nis"][20:], expected["nis"][20:], rtol=1e-9)
    assert system.states == ("x0", "x1", "x2")


def test_two_noises_are_a_loop_in_numpy():
    system, block = made()
    samples = np.random.default_rng(2).normal(size=(80, 3)) * 2.0
    found = scan(block, samples)
    names = ["mean.x0", "mean.x1", "mean.x2", "probabilities.0", "probabilities.1"]
    np.testing.assert_allclose(np.column_stack([found[n] for n in names]), slow(system, samples), rtol=1e-8, atol=1e-12)


def test_what_is_missing_says_nothing():
    _, block = made()
    sample = rebuild(skeleton(block.Sample), [0.3, 1.0, np.nan])
    after, _ = block.step(block.init(), sample)
    np.testing.assert_allclose(after.probabilities, np.full(2, 0.5) @ SWITCHING)
    held, estimate = block.step(after, rebuild(sample, [np.nan, 5.0, 5.0]))
    assert held == after
    assert estimate.present == estimate.nis == 0.0


def test_refused():
    system, block = made()
    with pytest.raises(ParameterError, match="at least one filter"):
        StationaryBank.design(system, block.model, block.parameters, (), R, ((1.0,),))
    with pytest.raises(ParameterError, match="expected 2 rows of 2"):
        StationaryBank.design(system, block.model, block.parameters, NOISES, R, ((1.0,),))
