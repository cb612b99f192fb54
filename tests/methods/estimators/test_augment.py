"""Augmented models: parameters as states, and states of the past."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pytest

from example_models import Cart, CartParameters, ContinuousCart, Pendulum, Two
from tierod.core.block import units
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators import augment
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.models.linear import discretise


def test_state_grows_and_the_equations_use_it():
    model = augment(Cart, "damping", "mass")
    assert model.State._fields == ("position", "speed", "damping", "mass")
    assert units(model.State) == ["m", "m/s", "N*s/m", "kg"]
    assert (model.Input, model.Output, model.Parameters) == (Cart.Input, Cart.Output, Cart.Parameters)
    x = model.State(1.0, 2.0, 0.7, 3.0)
    moved = model.transition(x, Cart.Input(5.0), CartParameters())
    plain = Cart.transition(Two(1.0, 2.0), Cart.Input(5.0), CartParameters(mass=3.0, damping=0.7))
    assert moved == (*plain, 0.7, 3.0)
    assert model.output(x, Cart.Input(5.0), CartParameters()) == Cart.output(Two(1.0, 2.0), None, CartParameters())
    assert model is augment(Cart, "damping", "mass")


def test_a_continuous_model_stays_continuous_and_can_be_discretised():
    model = augment(ContinuousCart, "mass")
    slope = model.derivative(model.State(0.0, 1.0, 4.0), Cart.Input(2.0), CartParameters())
    assert slope == (1.0, (2.0 - 0.5) / 4.0, 0.0)
    assert not hasattr(model, "transition")
    sampled = discretise(model, "euler")
    p = sampled.Parameters(CartParameters(), 0.1)
    assert sampled.transition(model.State(0.0, 1.0, 4.0), Cart.Input(2.0), p).mass == 4.0


def test_nested_parameters():
    sampled = discretise(ContinuousCart, "midpoint")
    model = augment(sampled, "continuous.damping")
    p = sampled.Parameters(CartParameters(), 0.1)
    assert model.State._fields[-1] == "continuous_damping"
    x = model.State(0.0, 1.0, 3.0)
    changed = sampled.Parameters(CartParameters(damping=3.0), 0.1)
    plain = sampled.transition(Two(0.0, 1.0), Cart.Input(0.0), changed)
    assert model.transition(x, Cart.Input(0.0), p) == (*plain, 3.0)
    assert p.continuous.damping == 0.5


def test_the_filter_finds_the_parameter():
    rng = np.random.default_rng(0)
    truth, state, rows = CartParameters(damping=1.4), Two(0.0, 0.0), []
    for k in range(4000):
        force = 3.0 * np.sign(np.sin(0.05 * k))
        state = Cart.transition(state, Cart.Input(float(force)), truth)
        rows.append([force, state.position + 0.01 * rng.normal(), state.speed + 0.01 * rng.normal()])
    model = augment(Cart, "damping")
    block = KalmanFilter(
        model,
        CartParameters(),
        initial_mean=(0.0, 0.0, CartParameters().damping),
        initial_variance=(1.0, 1.0, 1.0),
        process_noise=(1e-8, 1e-8, 1e-9),
        measurement_noise=(1e-4, 1e-4),
    )
    result = scan(block, rows)
    error = abs(result["mean.damping"][-1] - 1.4)
    assert error < 0.02
    assert error < 4.0 * np.sqrt(result["variance.damping"][-1])


@dataclass(frozen=True)
class Mixed:
    count: int = 3
    size: Annotated[float, "m"] = 1.0


class Odd(Pendulum):
    Parameters = Mixed


@pytest.mark.parametrize(
    ("model", "names", "words"),
    [
        (Cart, ("damp",), "did you mean 'damping'"),
        (Cart, (), "at least one"),
        (augment(Cart, "mass"), ("mass",), "has a state 'mass' already"),
        (Cart, ("mass.of",), "has no part 'of'"),
        (Odd, ("count",), "is not a float"),
    ],
)
def test_wrong_names_are_refused(model, names, words):
    with pytest.raises(ParameterError, match=words):
        augment(model, *names)


Q, R = (0.1, 0.2, 0.3), (0.5, 0.6)
