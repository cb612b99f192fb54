import dataclasses
import itertools

import numpy as np
import pytest

from example_models import (
    Cart,
    CartParameters,
    Pendulum,
    PendulumParameters,
    assert_floats_equal_scan,
    named,
    random_linear,
    with_gaps,
)
from textbook_filters import unscented_step
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators import KalmanFilter
from tierod_lab.methods.unscented import UnscentedFilter

SHAPES = [(1.0, 2.0, 0.0), (0.5, 2.0, 1.0), (0.1, 2.0, 0.0), (1.0, 0.0, 1.0)]


def pendulum(kind=UnscentedFilter, **changes):
    fields = {
        "initial_mean": (0.5, 0.0),
        "initial_variance": (0.2, 0.2),
        "process_noise": (1e-5, 1e-4),
        "measurement_noise": (0.01, 0.02),
    }
    return kind(Pendulum, PendulumParameters(), **(fields | changes))


def samples(count=150):
    rng = np.random.default_rng(2)
    return np.hstack([rng.normal(size=(count, 1)), with_gaps(rng, rng.normal(size=(count, 2)) * 0.5, 0.2)])


@pytest.mark.parametrize("redraw", [True, False])
@pytest.mark.parametrize(("alpha", "beta", "kappa"), SHAPES)
def test_agrees_with_the_textbook(alpha, beta, kappa, redraw):
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


@pytest.mark.parametrize("update", ["schmidt", "printed"])
def test_equals_the_kalman_filter_on_a_linear_model(update):
    rng = np.random.default_rng(8)
    _, model, parameters = random_linear(rng, 3, 2, 2)
    fields = {
        "initial_mean": (1.0, 2.0, 3.0),
        "initial_variance": (1.0, 0.5, 2.0),
        "process_noise": (0.1, None, 0.2),
        "measurement_noise": (0.3, 0.4),
        "input_noise": (None, 0.5),
        "maskable": ("x1",),
        "covariance_update": update,
        "full_covariance": True,
    }
    data = np.hstack([rng.normal(size=(60, 2)), with_gaps(rng, rng.normal(size=(60, 2))), rng.random((60, 1))])
    data[30:33, 1] = np.nan
    unscented = scan(UnscentedFilter(model, parameters, **fields), data)
    kalman = scan(KalmanFilter(model, parameters, **fields), data)
    assert unscented.names == kalman.names
    whole = kalman["present"] > 0
    np.testing.assert_allclose(unscented.values[whole], kalman.values[whole], rtol=1e-7, atol=1e-9)


def test_floats_agree_with_the_scan():
    assert_floats_equal_scan(pendulum(maskable=("rate",)), np.hstack([samples(60), np.full((60, 1), 0.5)]), rtol=1e-9)


def test_a_mean_that_the_extended_filter_gets_wrong():
    class Square:
        State, Input, Output, Parameters = named("S", ["x"]), named("I", []), named("O", ["y"]), CartParameters

        @staticmethod
        def transition(x, u, p):
            return Square.State(x.x * x.x)

        @staticmethod
        def output(x, u, p):
            return Square.Output(x.x)

    fields = ((1.0,), (0.25,), (0.0,), (1.0,))
    unscented = UnscentedFilter(Square, CartParameters(), *fields, kappa=2.0, beta=0.0)
    extended = KalmanFilter(Square, CartParameters(), *fields)
    missing = unscented.Sample(Square.Input(), Square.Output(float("nan")))
    assert unscented.step(unscented.init(), missing)[1].mean.x == pytest.approx(1.25)
    assert unscented.step(unscented.init(), missing)[1].variance.x == pytest.approx(4 * 0.25 + 2 * 0.25**2)
    assert extended.step(extended.init(), missing)[1].mean.x == pytest.approx(1.0)


@pytest.mark.parametrize("redraw", [True, False])
def test_any_pattern_of_missing_values_leaves_the_state_finite(redraw):
    block = pendulum(redraw=redraw, maskable=("angle",))
    patterns = np.array(list(itertools.product((0.1, np.nan, np.inf), repeat=4)))
    data = np.vstack([np.random.default_rng(0).permutation(patterns), np.full((20, 4), np.nan)])
    assert np.isfinite(scan(block, data).state.values).all()


def test_a_state_known_exactly_does_no_harm():
    block = UnscentedFilter(Cart, CartParameters(), (0.0, 1.0), (0.0, 0.0), (None, None), (0.1, 0.1))
    result = scan(block, np.ones((50, 3)))
    assert np.isfinite(result.values).all()
    np.testing.assert_array_equal(result["variance.speed"], 0.0)


def test_too_many_states_and_wrong_spreads_are_refused():
    _, model, parameters = random_linear(np.random.default_rng(0), 13, 1, 1)
    many = (1.0,) * 13
    with pytest.raises(ParameterError, match="at most 12 states"):
        UnscentedFilter(model, parameters, many, many, many, (1.0,))
    for changes in ({"alpha": 0.0}, {"kappa": -2.0}):
        with pytest.raises(ParameterError, match="expected alpha > 0"):
            dataclasses.replace(pendulum(), **changes)
