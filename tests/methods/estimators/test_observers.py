"""The fixed-lag smoother against a Kalman filter whose state holds every lag."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from example_models import (
    Cart,
    CartParameters,
    ContinuousCart,
    Two,
    random_linear,
)
from tierod.core.block import rebuild, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators import Luenberger
from tierod.methods.estimators.observers import FixedLag
from tierod.methods.estimators.riccati import stationary_gain
from tierod.models.linear import LinearSystem, linearise
from tierod_lab.methods.pole_placement import observer_gain

SYSTEM = linearise(Cart, CartParameters(), (0.0, 0.0), (0.0,))
FULL = Luenberger(Cart, CartParameters(), (0.0, 0.0), observer_gain(SYSTEM, (0.5, 0.6)))


def drive(start, forces, parameters=CartParameters()):  # noqa: B008 - frozen
    state, rows = start, []
    for force in forces:
        state = Cart.transition(state, Cart.Input(float(force)), parameters)
        rows.append([force, *state])
    return np.array(rows)


def test_agrees_with_the_matrices_of_the_textbook():
    rng = np.random.default_rng(1)
    system, model, parameters = random_linear(rng, 4, 2, 2)
    gain = rng.normal(size=(4, 2)) * 0.1
    block = Luenberger(model, parameters, (1.0, 0.0, 0.0, -1.0), tuple(tuple(map(float, row)) for row in gain))
    data = rng.normal(size=(50, 4))
    mean, expected = np.array(block.initial_mean), []
    for row in data:
        u, y = row[:2], row[2:]
        mean = system.A @ mean + system.B @ u
        innovation = y - system.C @ mean - system.D @ u
        mean = mean + gain @ innovation
        expected.append([*mean, *innovation])
    np.testing.assert_allclose(scan(block, data).values, expected, rtol=1e-9, atol=1e-12)


def test_the_error_dies_away_with_the_chosen_poles():
    samples = drive(Two(3.0, -2.0), np.sin(np.arange(60) / 5.0))
    result = scan(FULL, samples)
    error = np.hypot(result["mean.position"] - samples[:, 1], result["mean.speed"] - samples[:, 2])
    assert error[0] > 0.1
    assert error[-1] < 1e-9
    np.testing.assert_allclose(error[31] / error[30], 0.6, rtol=1e-2)


def test_missing_outputs_predict_and_missing_inputs_hold():
    result = scan(FULL, [[1.0, 0.2, 0.1], [1.0, np.nan, np.nan], [np.nan, 5.0, 5.0]])
    before = Two(result["mean.position"][0], result["mean.speed"][0])
    predicted = Cart.transition(before, Cart.Input(1.0), CartParameters())
    np.testing.assert_allclose(result.values[1, :2], predicted)
    np.testing.assert_array_equal(result.values[2, :2], result.values[1, :2])


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ((ContinuousCart, CartParameters(), (0.0, 0.0), FULL.gain), "discretise"),
        ((Cart, CartParameters(), (0.0,), FULL.gain), "initial_mean needs 2"),
        ((Cart, CartParameters(), (0.0, 0.0), ((1.0,), (1.0,))), "expected 2 .position, speed. of 2"),
    ],
)
def test_wrong_tuning_is_refused(fields, words):
    with pytest.raises(ParameterError, match=words):
        Luenberger(*fields)


LAG = 6
Q, R = (0.1, 0.2, 0.3), (0.5, 0.6)


def made(lag=LAG, states=("x1", "x0")):
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
    system, block = made()
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


def test_more_lag_knows_more():
    variances = [made(lag)[1].variances[0] for lag in (1, 3, 10, 40)]
    assert variances == sorted(variances, reverse=True)
    assert variances[-1] == pytest.approx(made(60)[1].variances[0], rel=1e-3)


def test_missing_samples_hold_or_only_predict():
    _, block = made()
    state, _ = block.step(block.init(), rebuild(skeleton(block.Sample), [0.5, 1.0, -1.0]))
    held, estimate = block.step(state, rebuild(skeleton(block.Sample), [np.nan, 1.0, 1.0]))
    assert held.mean == state.mean
    assert held.recent[0][1:] == state.recent[0][:-1]
    blind, estimate = block.step(state, rebuild(skeleton(block.Sample), [0.5, np.nan, np.nan]))
    assert blind.recent[0][1:] == state.recent[0][:-1]
    assert all(np.isfinite(value) for value in estimate.smoothed)


def test_refused():
    system, block = made()
    with pytest.raises(ParameterError, match="did you mean 'x0'|no state 'x9'"):
        made(states=("x9",))
    with pytest.raises(ParameterError, match="at least 1 sample"):
        made(0)
    with pytest.raises(ParameterError, match="same lag"):
        dataclasses.replace(block, weights=block.weights[:1])
    assert system.states == ("x0", "x1", "x2")
