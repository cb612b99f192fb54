"""Time to a limit against drawn trends."""

import numpy as np
import pytest

from tierod.methods.trends.fleet_alarms import chance_by, time_to_limit

LEVEL = np.array([[5.0, 0.01], [5.0, 0.0], [8.0, 0.0]])
SPREAD = np.array([[[0.01, -1e-5], [-1e-5, 4e-6]], [[0.01, 0.0], [0.0, 1e-12]], [[0.01, 0.0], [0.0, 1e-12]]])
LIMIT = np.full(3, 7.5)


def test_quantiles_are_those_of_drawn_trends():
    drawn = np.random.default_rng(0).multivariate_normal(LEVEL[0], SPREAD[0], 400_000)
    for share in (0.05, 0.5, 0.9):
        at = time_to_limit(LEVEL, SPREAD, LIMIT, share)[0]
        assert np.mean(drawn[:, 0] + at * drawn[:, 1] >= 7.5) == pytest.approx(share, abs=0.003)
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.5)[0] == pytest.approx(250.0)


def test_no_trend_never_and_beyond_the_limit_now():
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.05)[1] == np.inf
    assert time_to_limit(LEVEL, SPREAD, LIMIT, 0.5)[2] == 0.0
    assert chance_by(LEVEL, SPREAD, LIMIT, np.zeros(3))[2] > 0.99
