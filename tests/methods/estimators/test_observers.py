"""Observers and banks with stationary gains."""

from __future__ import annotations

import numpy as np
import pytest

from example_models import random_linear
from tierod.core.graph import scan
from tierod.methods.estimators.observers import FixedLag, stationary_gain
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.linear import LinearSystem

LAG = 6
Q, R = (0.1, 0.2, 0.3), (0.5, 0.6)


def lagged(lag=LAG, states=("x1", "x0")):
    system, model, parameters = random_linear(np.random.default_rng(0), 3, 1, 2)
    return system, FixedLag.design(system, model, parameters, Q, R, states, lag)


def augmented(system, state):
    n = len(system.A)
    A = np.zeros((n + LAG, n + LAG))
    A[:n, :n], A[n, state] = system.A, 1.0
    A[n + 1 :, n:-1] = np.eye(LAG - 1)
    C = np.hstack([system.C, np.zeros((2, LAG))])
    return LinearSystem.of(A, C, np.vstack([system.B, np.zeros((LAG, 1))]), system.D)


@pytest.mark.parametrize("name", ["x0", "x1"])
def test_it_is_the_augmented_filter(name):
    system, block = lagged()
    large = augmented(system, system.states.index(name))
    gain = stationary_gain(large, (*Q, *[0.0] * LAG), R)
    samples, mean, expected = np.random.default_rng(1).normal(size=(60, 3)), np.zeros(3 + LAG), []
    for row in samples:
        mean = large.A @ mean + large.B @ row[:1]
        mean = mean + gain.filter @ (row[1:] - large.C @ mean - large.D @ row[:1])
        expected.append([mean[-1], *mean[:3]])
    found = scan(block, samples)
    np.testing.assert_allclose(found[f"smoothed.{name}"], np.array(expected)[:, 0], rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(found["mean.x2"], np.array(expected)[:, 3], rtol=1e-7, atol=1e-10)
    variance = dict(zip(block.states, block.variances, strict=True))[name]
    assert variance == pytest.approx(gain.covariance[-1, -1], rel=1e-6)


SWITCHING = np.array([[0.97, 0.03], [0.1, 0.9]])
NOISES = ((0.1, 0.2, 0.3), (2.0, 2.0, 2.0))
BANK_R = (0.5, 0.6)


def made(noises=NOISES, switching=SWITCHING):
    system, model, parameters = random_linear(np.random.default_rng(0), 3, 1, 2)
    rows = tuple(map(tuple, np.atleast_2d(switching).tolist()))
    return system, StationaryBank.design(system, model, parameters, noises, BANK_R, rows)


def slow(system, samples):
    gains = [stationary_gain(system, noise, BANK_R) for noise in NOISES]
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


def test_two_noises_are_a_loop_in_numpy():
    system, block = made()
    samples = np.random.default_rng(2).normal(size=(80, 3)) * 2.0
    found = scan(block, samples)
    names = ["mean.x0", "mean.x1", "mean.x2", "probabilities.0", "probabilities.1"]
    np.testing.assert_allclose(np.column_stack([found[n] for n in names]), slow(system, samples), rtol=1e-8, atol=1e-12)
