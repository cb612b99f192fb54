"""linear"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from example_models import (
    Cart,
    CartParameters,
    ContinuousCart,
    Pendulum,
    PendulumParameters,
    Two,
    named,
    random_linear,
)
from tierod.core.errors import ParameterError
from tierod.core.graph import maths
from tierod.models.linear import (
    METHODS,
    LinearSystem,
    describe,
    discretise,
    linearise,
    modes,
    sampled,
    scaled,
    zero_order_hold,
)


def test_jacobians_of_a_nonlinear_model():
    p = PendulumParameters()
    system = linearise(Pendulum, p, (0.4, 0.2), (1.5,))
    slope = -9.81 / p.length * math.cos(0.4) - 1.5 * math.sin(0.4)
    np.testing.assert_allclose(system.A, [[1.0, 0.02], [0.02 * slope, 1.0]])
    np.testing.assert_allclose(system.B, [[0.0], [0.02 * math.cos(0.4)]])
    np.testing.assert_allclose(system.C, [[p.length * math.cos(0.4), 0.0], [0.0, 1.04]])
    np.testing.assert_array_equal(system.D, np.zeros((2, 1)))
    assert (system.states, system.inputs, system.outputs) == (("angle", "rate"), ("torque",), ("height", "rate"))


def test_zero_order_hold_is_the_known_solution():
    p, T = CartParameters(), 0.1
    linear = zero_order_hold(ContinuousCart, p, T, (0.0, 0.0), (0.0,))
    decay = math.exp(-p.damping / p.mass * T)
    x = linear.model.transition(Two(1.0, 2.0), Cart.Input(3.0), linear.parameters)
    gained = (1.0 - decay) / p.damping
    assert x.speed == pytest.approx(decay * 2.0 + gained * 3.0)
    lag = p.mass / p.damping
    position = 1.0 + lag * (1.0 - decay) * 2.0 + (T - lag * (1.0 - decay)) / p.damping * 3.0
    assert x.position == pytest.approx(position)
    assert linear.model.output(x, Cart.Input(3.0), linear.parameters) == x


def test_zero_order_hold_is_the_limit_of_small_steps_and_stable_where_they_are_not():
    stiff = CartParameters(mass=1e-4, damping=1.0)
    linear = zero_order_hold(ContinuousCart, stiff, 0.1, (0.0, 0.0), (0.0,))
    fine = discretise(ContinuousCart, "rk4", 2000)
    x, u = Two(0.3, 1.0), Cart.Input(0.5)
    exact = linear.model.transition(x, u, linear.parameters)
    np.testing.assert_allclose(exact, fine.transition(x, u, fine.Parameters(stiff, 0.1)), rtol=1e-6)
    assert abs(discretise(ContinuousCart, "rk4").transition(x, u, fine.Parameters(stiff, 0.1)).speed) > 1e6


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.integers(1, 5), st.integers(0, 2), st.integers(1, 3))
def test_system_to_model_and_back(seed, n, inputs, outputs):
    system, model, parameters = random_linear(np.random.default_rng(seed), n, inputs, outputs)
    back = linearise(model, parameters, (0.0,) * n, (0.0,) * inputs)
    for ours, theirs in zip((back.A, back.B, back.C, back.D), (system.A, system.B, system.C, system.D), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_zeros_and_ones_are_structure():
    linear = zero_order_hold(ContinuousCart, CartParameters(), 0.1, (0.0, 0.0), (0.0,))
    assert linear.parameters.transition[0][0] == 1
    assert isinstance(linear.parameters.transition[0][0], int)
    assert linear.parameters.transition[1][0] is None
    assert linear.parameters.feedthrough == ((None,), (None,))


class Root:
    State, Input, Output, Parameters = named("S", ["x"]), named("I", []), named("O", ["x"]), CartParameters

    @staticmethod
    def transition(x, u, p):
        return Root.State(maths.sqrt(x.x))

    output = transition


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: LinearSystem.of(np.ones((2, 3)), np.ones((1, 2))), "expected .n, n."),
        (lambda: LinearSystem.of([[math.nan]], [[1.0]]), "NaN or infinity"),
        (lambda: LinearSystem.of(np.eye(2), np.ones((1, 2)), B=[1.0, 2.0, 3.0]), r"B \(3, 1\).*expected .n, n."),
        (lambda: sampled(LinearSystem.of([[1.0]], [[1.0]]), 0.0), "sample_time is 0.0"),
        (lambda: linearise(Root, CartParameters(), (0.0,), ()), "no finite Jacobian"),
    ],
)
def test_what_is_not_a_system_is_refused(call, words):
    with pytest.raises(ParameterError, match=words):
        call()


def test_a_hidden_mode_is_found_with_its_direction():
    turn = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, -1.0], [1.0, 0.0, 1.0]])
    A = turn @ np.diag([0.9, 0.5, 0.2]) @ np.linalg.inv(turn)
    C = np.array([[1.0, 0.0, 1.0]]) @ np.linalg.inv(turn)
    found = modes(LinearSystem.of(A, C, states=("a", "b", "c")))
    assert found[0].margin < 1e-12
    assert found[1].margin > 1e-3
    assert found[0].eigenvalue == pytest.approx(0.5)
    np.testing.assert_allclose(found[0].direction / found[0].direction[0], turn[:, 1] / turn[0, 1], atol=1e-9)
    assert found[0].number == "0.5"
    assert describe(found[0].direction, ("a", "b", "c")) == "1 a + 0.5 b"


def test_a_finely_sampled_system_keeps_its_modes_apart():
    M = np.array([[-1.0, 1.0], [0.0, -2.0]])
    for outputs, hidden in (([[1.0, 0.0]], False), ([[0.0, 1.0]], True)):
        margin = modes(LinearSystem.of(np.eye(2) + 1e-8 * M, outputs))[0].margin
        assert (margin < 1e-7) == hidden


def test_complex_modes():
    found = modes(LinearSystem.of([[0.0, 1.0], [-1.0, 0.0]], [[1.0, 0.0]]))
    assert sorted(mode.eigenvalue.imag for mode in found) == pytest.approx([-1.0, 1.0])
    assert found[0].margin > 0.1
    assert "j" in found[0].number


def test_scaling_of_units_leaves_the_margin_alone():
    rng = np.random.default_rng(0)
    A, C = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    units = np.array([1e6, 1.0, 1e-6])
    plain = modes(LinearSystem.of(A, C))[0].margin
    scaled_margin = modes(LinearSystem.of(A * units[:, None] / units, C / units * 1e-3))[0].margin
    assert 0.1 < scaled_margin / plain < 10.0


def test_an_identity_has_size_one():
    form = scaled(LinearSystem.of(np.eye(2), np.eye(2)))
    assert form.size == 1.0
    np.testing.assert_array_equal(form.A, 0.0)


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
