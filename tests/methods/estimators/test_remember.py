"""A model that remembers, filtered, is a fixed-lag smoother."""

import numpy as np
import pytest

from example_models import Pendulum, PendulumParameters, random_linear
from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators.fixed_lag import FixedLag
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.remember import remember
from tierod.methods.estimators.unscented import UnscentedFilter

Q, R = (0.1, 0.2, 0.3), (0.5, 0.6)


def test_settled_it_is_the_stationary_smoother():
    system, model, parameters = random_linear(np.random.default_rng(0), 3, 1, 2)
    lag = 4
    long = remember(model, lag, "x1", "x0")
    block = KalmanFilter(long, parameters, (0.0,) * 11, (1.0,) * 11, (*Q, *[None] * 8), R)
    short = FixedLag.design(system, model, parameters, Q, R, ("x1", "x0"), lag)
    samples = np.random.default_rng(1).normal(size=(400, 3))
    found, expected = scan(block, samples), scan(short, samples)
    for name in ("x1", "x0"):
        np.testing.assert_allclose(
            found[f"mean.{name}_4_ago"][200:], expected[f"smoothed.{name}"][200:], rtol=1e-6, atol=1e-9
        )
    assert found["variance.x1_4_ago"][-1] == pytest.approx(short.variances[0], rel=1e-6)


def test_a_pendulum_is_known_better_afterwards():
    p = PendulumParameters()
    long = remember(Pendulum, 10, Pendulum.State._fields[0])
    assert units(long.State)[2] == units(Pendulum.State)[0]
    for kind in (KalmanFilter, UnscentedFilter):
        block = kind(long, p, (0.5, *[0.0] * 11), (0.2,) * 12, (1e-4, 1e-4, *[None] * 10), (0.01, 0.02))
        found = scan(block, np.random.default_rng(2).normal(size=(80, 3)) * 0.1)
        angle = Pendulum.State._fields[0]
        assert found[f"variance.{angle}_10_ago"][70] < found[f"variance.{angle}"][60]
        assert np.isfinite(found[f"mean.{angle}_10_ago"]).all()


@pytest.mark.parametrize(
    ("call", "words"), [((0, "x0"), "at least 1"), ((3,), "at least one name"), ((3, "y"), "no state")]
)
def test_refused(call, words):
    _, model, _ = random_linear(np.random.default_rng(0), 3, 1, 2)
    with pytest.raises(ParameterError, match=words):
        remember(model, *call)
