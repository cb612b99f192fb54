import math

import numpy as np
import pytest

from example_models import Cart, CartParameters, ContinuousCart, Two, named
from tierod.core.errors import ParameterError
from tierod.models.linear import METHODS, discretise


class Decay:
    """x' = -x^2 with known solution 1 / (t + 1 / x0); the second state is constant."""

    State, Input, Output, Parameters = named("S", ["x", "c"]), named("I", []), named("O", ["x"]), CartParameters

    @staticmethod
    def derivative(x, u, p):
        return Decay.State(-x.x * x.x, 0.0)

    @staticmethod
    def output(x, u, p):
        return Decay.Output(x.x)


def error(method, step, steps=1):
    model = discretise(Decay, method, steps)
    p, x = model.Parameters(CartParameters(), step), Decay.State(2.0, 5.0)
    for _ in range(round(1.0 / step)):
        x = model.transition(x, Decay.Input(), p)
    assert x.c == 5.0
    return abs(x.x - 1.0 / 1.5)


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("midpoint", 2), ("rk4", 4)])
def test_order_of_convergence(method, order):
    ratio = error(method, 0.05) / error(method, 0.025)
    assert math.log2(ratio) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("method", METHODS)
def test_inner_steps_are_smaller_samples(method):
    assert error(method, 0.1, steps=2) == pytest.approx(error(method, 0.05), rel=1e-9)


def test_euler_is_the_model_written_by_hand_and_its_class_is_kept():
    model = discretise(ContinuousCart, "euler")
    p = model.Parameters(CartParameters(), 0.1)
    assert model.transition(Two(1.0, 2.0), Cart.Input(3.0), p) == pytest.approx(
        Cart.transition(Two(1.0, 2.0), Cart.Input(3.0), CartParameters())
    )
    assert model.output(Two(1.0, 2.0), Cart.Input(3.0), p) == (1.0, 2.0)
    assert model is discretise(ContinuousCart, "euler")
    assert (model.State, model.Input, model.Output) == (Two, Cart.Input, Cart.Output)
    assert np.isfinite(model.transition(Two(0.0, 0.0), Cart.Input(1.0), p)).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((ContinuousCart, "rk"), "did you mean 'rk4'"),
        ((ContinuousCart, "rk4", 0), "steps is 0"),
        ((Cart, "rk4"), "only a continuous model"),
    ],
)
def test_what_cannot_be_discretised_is_refused(arguments, words):
    with pytest.raises(ParameterError, match=words):
        discretise(*arguments)
