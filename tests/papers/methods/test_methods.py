"""Pole placement, the stationary and the unscented filter, against textbooks, python-control and each other."""

import itertools

import control
import numpy as np
import pytest

from example_models import (
    Cart,
    CartParameters,
    Pendulum,
    PendulumParameters,
    assert_floats_equal_scan,
    with_gaps,
)
from textbook_filters import unscented_step
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.observers import stationary_gain
from tierod.models.linear import LinearSystem, linearise
from tierod_lab.methods.pole_placement import discrete_poles, observer_gain, place
from tierod_lab.methods.stationary import StationaryFilter
from tierod_lab.methods.unscented import UnscentedFilter


@pytest.mark.parametrize("poles", [(0.2, 0.3, 0.4, 0.5), (0.4 + 0.3j, 0.4 - 0.3j, 0.2, 0.3), (0.3,) * 4])
@pytest.mark.parametrize("unit", [1.0, 1e6])
def test_poles_are_the_requested_ones_in_any_unit(poles, unit):
    rng = np.random.default_rng(5)
    scale = np.diag([unit, 1.0, 1.0 / unit, 1.0])
    A, C = scale @ rng.normal(size=(4, 4)) @ np.linalg.inv(scale), rng.normal(size=(1, 4)) @ np.linalg.inv(scale)
    system = LinearSystem.of(A, C)
    closed = (np.eye(4) - np.array(observer_gain(system, poles)) @ C) @ A
    np.testing.assert_allclose(np.poly(closed), np.poly(np.array(poles)).real, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(
        np.poly(A - place(system, poles) @ C), np.poly(np.array(poles)).real, rtol=1e-4, atol=1e-7
    )
    assert discrete_poles((-15.0,), 0.01) == pytest.approx([np.exp(-0.15)])


HIDDEN = LinearSystem.of(np.diag([0.9, 0.8, 0.7]), [[1.0, 0.0, 1.0]], states=("angle", "bias", "rate"))


@pytest.mark.parametrize(
    ("poles", "words"),
    [
        ((0.1, 0.2, 0.3), "the direction 1 bias .eigenvalue 0.8. is not observable"),
        ((0.1, 0.2), "2 poles for 3 states"),
        ((0.1, 0.2, 0.3j), "not in complex pairs"),
        ((0.1, 0.2, np.nan), "not all finite"),
    ],
)
def test_what_cannot_be_placed_is_refused_with_its_name(poles, words):
    with pytest.raises(ParameterError, match=words):
        observer_gain(HIDDEN, poles)


NOISE = {"process_noise": (None, 0.01), "measurement_noise": (0.1, 0.2), "input_noise": (0.3,)}
BLOCK = StationaryFilter.design(Cart, CartParameters(), state=(0.0, 0.0), inputs=(0.0,), **NOISE)
SYSTEM = linearise(Cart, CartParameters(), (0.0, 0.0), (0.0,))


def test_dlqe_of_python_control_is_the_predictor_gain():
    found = stationary_gain(SYSTEM, (0.02, 0.01), (0.1, 0.2))
    theirs, covariance, _ = control.dlqe(SYSTEM.A, np.eye(2), SYSTEM.C, np.diag([0.02, 0.01]), np.diag([0.1, 0.2]))
    np.testing.assert_allclose(found.predictor, theirs, rtol=1e-9)
    np.testing.assert_allclose(found.predicted_covariance, covariance, rtol=1e-9)
    decaying = stationary_gain(LinearSystem.of(np.diag([0.9, 0.5]), [[0.0, 1.0]]), (1.0, 1.0), (1.0,))
    np.testing.assert_allclose(decaying.covariance[0, 0], 1.0 / (1.0 - 0.81))  # a hidden state that decays


def test_the_stationary_block_is_the_limit_of_the_time_varying_filter():
    data = np.random.default_rng(3).normal(size=(3000, 3))
    expected = scan(KalmanFilter(Cart, CartParameters(), (0.0, 0.0), (1.0, 1.0), **NOISE), data)
    found = scan(BLOCK, data)
    assert expected.names == found.names
    np.testing.assert_allclose(found.values[2000:], expected.values[2000:], rtol=1e-6, atol=1e-8)
    rng = np.random.default_rng(0)
    assert_floats_equal_scan(BLOCK, with_gaps(rng, rng.normal(size=(60, 3))))
    one = scan(BLOCK, [[0.0, 0.7, np.nan]])
    spread = one["innovation_variance.position"][0]
    np.testing.assert_allclose(one["nis"][0], one["innovation.position"][0] ** 2 / spread)


def pendulum(**changes):
    fields = {
        "initial_mean": (0.5, 0.0),
        "initial_variance": (0.2, 0.2),
        "process_noise": (1e-5, 1e-4),
        "measurement_noise": (0.01, 0.02),
    }
    return UnscentedFilter(Pendulum, PendulumParameters(), **(fields | changes))


def samples(count=150):
    rng = np.random.default_rng(2)
    return np.hstack([rng.normal(size=(count, 1)), with_gaps(rng, rng.normal(size=(count, 2)) * 0.5, 0.2)])


@pytest.mark.parametrize("redraw", [True, False])
@pytest.mark.parametrize(("alpha", "beta", "kappa"), [(1.0, 2.0, 0.0), (0.1, 2.0, 0.0), (1.0, 0.0, 1.0)])
def test_the_unscented_filter_agrees_with_the_textbook(alpha, beta, kappa, redraw):
    block = pendulum(alpha=alpha, beta=beta, kappa=kappa, redraw=redraw)
    p = block.parameters
    mean, covariance, rows = np.array(block.initial_mean), np.diag(block.initial_variance), []
    for row in samples():
        u = Pendulum.Input(float(row[0]))
        mean, covariance, *figures = unscented_step(
            mean,
            covariance,
            lambda x, u=u: np.array(Pendulum.transition(Pendulum.State(*map(float, x)), u, p)),
            lambda x: np.array(Pendulum.output(Pendulum.State(*map(float, x)), None, p)),
            np.diag(block.process_noise),
            np.diag(block.measurement_noise),
            row[1:],
            alpha,
            beta,
            kappa,
            redraw,
        )
        innovation, spread, nis, count = figures
        rows.append([*mean, *np.diag(covariance), *innovation, *spread, nis, count])
    result = scan(block, samples()).values
    finite = np.isfinite(rows)
    np.testing.assert_allclose(result[finite], np.array(rows)[finite], rtol=1e-5, atol=1e-8)


def test_any_pattern_of_missing_values_leaves_the_state_finite_and_floats_agree_with_the_scan():
    patterns = np.array(list(itertools.product((0.1, np.nan, np.inf), repeat=4)))
    data = np.vstack([np.random.default_rng(0).permutation(patterns), np.full((20, 4), np.nan)])
    for redraw in (True, False):
        assert np.isfinite(scan(pendulum(redraw=redraw, maskable=("angle",)), data).state.values).all()
    assert_floats_equal_scan(pendulum(maskable=("rate",)), np.hstack([samples(60), np.full((60, 1), 0.5)]), rtol=1e-9)
    known = UnscentedFilter(Cart, CartParameters(), (0.0, 1.0), (0.0, 0.0), (None, None), (0.1, 0.1))
    np.testing.assert_array_equal(scan(known, np.ones((50, 3)))["variance.speed"], 0.0)
