from __future__ import annotations

import math

import numpy as np
import pytest

from example_models import Cart, CartParameters, ContinuousCart, Pendulum, PendulumParameters, Two, named
from tierod.models.linear import discretise, linearise, zero_order_hold


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
