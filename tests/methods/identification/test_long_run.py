import numpy as np
import pytest

from tierod.methods.identification.long_run import long_run_covariance, sandwich


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
