"""Switching, mixing and probabilities of interacting models."""

import numpy as np

from tierod.methods.estimators.stationary_bank import (
    mixing,
    mixture_variance,
    posterior,
    weighed,
)


def test_mixing_is_the_rule_of_bayes():
    switching, shares = np.array([[0.9, 0.1], [0.3, 0.7]]), np.array([0.2, 0.8])
    found = mixing(tuple(shares), tuple(map(tuple, switching.tolist())))
    np.testing.assert_allclose(found.predicted, shares @ switching)
    np.testing.assert_allclose(np.array(found.weights).T, switching * shares[:, None] / (shares @ switching))


def test_moments_of_a_mixture_are_those_of_its_draws():
    rng = np.random.default_rng(0)
    weights, means = (0.3, 0.7), ((1.0, -2.0), (0.5, 3.0))
    covariances = ((1.0, 0.4, 0.5), (0.2, -0.1, 2.0))
    draws = np.concatenate(
        [
            rng.multivariate_normal(mean, [[a, b], [b, c]], round(400_000 * weight))
            for weight, mean, (a, b, c) in zip(weights, means, covariances, strict=True)
        ]
    )
    mean = weighed(weights, means)
    spread = np.cov(draws.T)
    np.testing.assert_allclose(mean, draws.mean(axis=0), atol=0.01)
    variances = mixture_variance(weights, mean, means, [(each[0], each[2]) for each in covariances])
    np.testing.assert_allclose(variances, np.diag(spread), rtol=0.01)


def test_probabilities_where_likelihoods_would_underflow():
    first = 1.0 / (1.0 + np.exp(-1.0))
    np.testing.assert_allclose(posterior((0.5, 0.5), (-1e9, -1e9 - 1.0)), [first, 1.0 - first], rtol=1e-6)
    np.testing.assert_allclose(posterior((1e-300, 1.0), (0.0, -1e5)), (1.0, 0.0))
