"""Regressions, and the covariance of their coefficients."""

import numpy as np
import pytest

from tierod.methods.identification.regression import Rows, long_run_covariance, regress, sandwich, solved


def autoregressive(factor, count, seed):
    random, values = np.random.default_rng(seed), np.zeros(count)
    for k in range(1, count):
        values[k] = factor * values[k - 1] + random.standard_normal()
    return values[:, None]


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.9])
def test_it_is_the_variance_of_the_sum_of_an_autoregression(factor):
    scores = [autoregressive(factor, 20_000, seed) for seed in range(3)]
    expected = 60_000 / (1.0 - factor) ** 2
    assert long_run_covariance(scores)[0, 0] == pytest.approx(expected, rel=0.2)


def test_a_coordinate_without_information_gets_no_variance():
    scores = [np.random.default_rng(1).standard_normal((500, 2)) * [1.0, 0.0]]
    covariance = sandwich(np.diag([100.0, 0.0]), scores)
    assert covariance[0, 0] > 0.0
    assert np.isfinite(covariance).all()
    assert covariance[1, 1] == 0.0


def test_knowledge_from_elsewhere_counts_as_it_says():
    scores = [np.zeros((500, 1))]
    assert sandwich(np.array([[25.0]]), scores, np.array([[25.0]]))[0, 0] == pytest.approx(1.0 / 25.0)


def signals(seed, count=4000):
    random = np.random.default_rng(seed)
    time = np.arange(count) * 0.05
    return random, np.column_stack([np.exp(1j * time), np.exp(2.7j * time) * (1.0 + 0.3j)])


def test_noise_in_a_regressor_makes_no_bias_where_instruments_have_noise_of_their_own():
    found, naive = [], []
    for seed in range(40):
        random, true = signals(seed)
        seen, instruments = (true + 0.4 * random.normal(size=true.shape) for _ in range(2))
        target = true @ [2.0, -1.0] + 0.1 * random.normal(size=len(true))
        found.append(regress([Rows(target, seen, instruments)]).values)
        naive.append(regress([Rows(target, seen, seen)]).values)
    assert np.mean(found, axis=0) == pytest.approx([2.0, -1.0], abs=0.01)
    assert np.mean(naive, axis=0)[0] < 1.9


def test_deviations_hold_with_coloured_residuals():
    inside = 0
    for seed in range(60):
        random, true = signals(seed, 3000)
        white = random.normal(size=(3200, 2)) @ [1.0, 1j]
        coloured = np.convolve(white, np.full(30, 1 / 30), "same")[:3000]
        fit = regress([Rows(true @ [2.0, -1.0] + coloured, true, true)])
        inside += abs(fit.values[0] - 2.0) < 1.96 * fit.deviations[0]
    assert inside >= 52


def test_what_one_transient_shows_is_unsure():
    random, true = signals(3)
    bump = np.zeros(len(true), complex)
    bump[2000:2010] = 1.0
    columns = np.column_stack([true[:, 0], bump])
    target = columns @ [1.0, 1.0] + 0.05 * random.normal(size=len(true))
    spike = target.copy()
    spike[2000:2010] += 0.5
    assert regress([Rows(spike, columns, columns)]).deviations[1] > 0.2


def test_combinations_and_noise_are_not_reported():
    random, true = signals(4)
    near = true[:, 0] * 2.0 + 0.01 * true[:, 1]
    columns = np.column_stack([true[:, 0], near, 1j * true[:, 1]])
    fit = regress([Rows(columns @ [1.0, 1.0, 3.0], columns, columns)])
    assert np.isinf(fit.deviations[:2]).all()
    assert fit.values[2] == pytest.approx(3.0, abs=1e-6)
    assert np.isfinite(fit.deviations[2])
    noise, other = (random.normal(size=len(true)) for _ in range(2))
    seen, instruments = np.column_stack([true[:, 0], noise]), np.column_stack([true[:, 0], other])
    fit = regress([Rows(true[:, 0], seen, instruments)])
    assert fit.values == pytest.approx([1.0, 0.0])
    assert np.isinf(fit.deviations[1])


RANDOM = np.random.default_rng(3)
COLUMNS = RANDOM.normal(size=(400, 3))


def solution(columns, explained):
    return solved(columns.T @ columns, columns.T @ explained, float(explained @ explained), len(explained))


def test_parameters_and_their_deviations_come_out():
    explained = COLUMNS @ [2.0, -0.5, 0.1] + 0.05 * RANDOM.normal(size=400)
    found = solution(COLUMNS, explained)
    assert found.values == pytest.approx([2.0, -0.5, 0.1], abs=4.0 * found.deviations.max())
    assert found.deviations == pytest.approx(0.05 / 20.0, rel=0.2)
    assert found.left == pytest.approx(400 * 0.05**2, rel=0.2)


@pytest.mark.parametrize("third", [np.zeros(400), COLUMNS[:, 0] + 1e-7 * COLUMNS[:, 1]])
def test_regressors_that_are_zero_or_dependent_determine_nothing(third):
    assert solution(np.column_stack([COLUMNS[:, :2], third]), COLUMNS[:, 0]) is None
