import dataclasses
import itertools

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from example_models import Cart, CartParameters, ContinuousCart, assert_floats_equal_scan, random_linear, with_gaps
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators import KalmanFilter, stationary_gain
from tierod.models.linear import LinearSystem, linearise
from tierod_lab.methods.stationary import StationaryFilter

NOISE = {"process_noise": (None, 0.01), "measurement_noise": (0.1, 0.2), "input_noise": (0.3,)}
BLOCK = StationaryFilter.design(Cart, CartParameters(), state=(0.0, 0.0), inputs=(0.0,), **NOISE)
SYSTEM = linearise(Cart, CartParameters(), (0.0, 0.0), (0.0,))


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.integers(1, 4), st.integers(1, 3))
def test_the_gain_is_the_limit_of_the_riccati_recursion(seed, n, outputs):
    rng = np.random.default_rng(seed)
    system, _, _ = random_linear(rng, n, 1, outputs)
    # A system with a gain of a thousand loses six digits in either form.
    assume(np.max(np.abs(system.A)) < 30.0)
    Q, R = np.diag(0.1 + rng.random(n)), np.diag(0.1 + rng.random(outputs))
    found = stationary_gain(system, Q, R)
    before = np.eye(n)
    for _ in range(1000):
        K = before @ system.C.T @ np.linalg.inv(system.C @ before @ system.C.T + R)
        after = (np.eye(n) - K @ system.C) @ before
        before = system.A @ after @ system.A.T + Q
    np.testing.assert_allclose(found.filter, K, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.predictor, system.A @ K, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.covariance, after, rtol=1e-6, atol=1e-9)


def test_dlqe_of_python_control_is_the_predictor_gain():
    found = stationary_gain(SYSTEM, (0.02, 0.01), (0.1, 0.2))
    theirs, covariance, _ = control.dlqe(SYSTEM.A, np.eye(2), SYSTEM.C, np.diag([0.02, 0.01]), np.diag([0.1, 0.2]))
    np.testing.assert_allclose(found.predictor, theirs, rtol=1e-9)
    np.testing.assert_allclose(found.predicted_covariance, covariance, rtol=1e-9)
    assert not np.allclose(found.filter, theirs, rtol=1e-3)


def test_the_block_is_the_limit_of_the_time_varying_filter():
    rng = np.random.default_rng(3)
    data = rng.normal(size=(3000, 3))
    kalman = KalmanFilter(Cart, CartParameters(), (0.0, 0.0), (1.0, 1.0), **NOISE)
    expected, found = scan(kalman, data), scan(BLOCK, data)
    assert expected.names == found.names
    np.testing.assert_allclose(found.values[2000:], expected.values[2000:], rtol=1e-6, atol=1e-8)


def test_missing_data_leave_the_state_finite_and_the_figures_right():
    patterns = np.array(list(itertools.product((1.0, np.nan, np.inf, -np.inf), repeat=3)))
    result = scan(BLOCK, np.random.default_rng(0).permutation(patterns))
    assert np.isfinite(result.state.values).all()
    assert np.isfinite(result["nis"]).all()
    assert set(result["present"]) == {0.0, 1.0, 2.0}
    one = scan(BLOCK, [[0.0, 0.7, np.nan]])
    spread = one["innovation_variance.position"][0]
    np.testing.assert_allclose(one["nis"][0], one["innovation.position"][0] ** 2 / spread)


def test_floats_agree_with_the_scan():
    rng = np.random.default_rng(0)
    assert_floats_equal_scan(BLOCK, with_gaps(rng, rng.normal(size=(60, 3))))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: stationary_gain(
                LinearSystem.of(np.diag([1.0, 0.5]), [[0.0, 1.0]], states=("bias", "rate")), (1.0, 1.0), (1.0,)
            ),
            "the direction 1 bias .eigenvalue 1. is not observable",
        ),
        (lambda: stationary_gain(LinearSystem.of([[1.0]], [[1.0]]), (None,), (1.0,)), "process noise"),
        (lambda: stationary_gain(SYSTEM, (1.0,), (1.0, 1.0)), "expected 2 variances"),
        (lambda: stationary_gain(SYSTEM, (1.0, -1.0), (1.0, 1.0)), "process_noise"),
        (lambda: StationaryFilter.design(ContinuousCart, CartParameters(), (1.0,), (1.0,), (0.0,), ()), "discretise"),
        (lambda: dataclasses.replace(BLOCK, covariance=(1.0,)), "covariance has 1 entries; expected 3"),
    ],
)
def test_what_has_no_stationary_gain_is_refused(call, words):
    with pytest.raises(ParameterError, match=words):
        call()


def test_a_hidden_state_that_decays_is_no_obstacle():
    found = stationary_gain(LinearSystem.of(np.diag([0.9, 0.5]), [[0.0, 1.0]]), (1.0, 1.0), (1.0,))
    np.testing.assert_allclose(found.covariance[0, 0], 1.0 / (1.0 - 0.81))
