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
from tierod.models.linear import LinearSystem, discretise, linearise, sampled, zero_order_hold


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
