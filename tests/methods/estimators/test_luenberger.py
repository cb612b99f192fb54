import numpy as np
import pytest

from example_models import (
    Cart,
    CartParameters,
    ContinuousCart,
    Two,
    random_linear,
)
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.estimators import Luenberger
from tierod.models.linear import linearise
from tierod_lab.methods.pole_placement import observer_gain

SYSTEM = linearise(Cart, CartParameters(), (0.0, 0.0), (0.0,))
FULL = Luenberger(Cart, CartParameters(), (0.0, 0.0), observer_gain(SYSTEM, (0.5, 0.6)))


def drive(start, forces, parameters=CartParameters()):  # noqa: B008 - frozen
    state, rows = start, []
    for force in forces:
        state = Cart.transition(state, Cart.Input(float(force)), parameters)
        rows.append([force, *state])
    return np.array(rows)


def test_agrees_with_the_matrices_of_the_textbook():
    rng = np.random.default_rng(1)
    system, model, parameters = random_linear(rng, 4, 2, 2)
    gain = rng.normal(size=(4, 2)) * 0.1
    block = Luenberger(model, parameters, (1.0, 0.0, 0.0, -1.0), tuple(tuple(map(float, row)) for row in gain))
    data = rng.normal(size=(50, 4))
    mean, expected = np.array(block.initial_mean), []
    for row in data:
        u, y = row[:2], row[2:]
        mean = system.A @ mean + system.B @ u
        innovation = y - system.C @ mean - system.D @ u
        mean = mean + gain @ innovation
        expected.append([*mean, *innovation])
    np.testing.assert_allclose(scan(block, data).values, expected, rtol=1e-9, atol=1e-12)


def test_the_error_dies_away_with_the_chosen_poles():
    samples = drive(Two(3.0, -2.0), np.sin(np.arange(60) / 5.0))
    result = scan(FULL, samples)
    error = np.hypot(result["mean.position"] - samples[:, 1], result["mean.speed"] - samples[:, 2])
    assert error[0] > 0.1
    assert error[-1] < 1e-9
    np.testing.assert_allclose(error[31] / error[30], 0.6, rtol=1e-2)


def test_missing_outputs_predict_and_missing_inputs_hold():
    result = scan(FULL, [[1.0, 0.2, 0.1], [1.0, np.nan, np.nan], [np.nan, 5.0, 5.0]])
    before = Two(result["mean.position"][0], result["mean.speed"][0])
    predicted = Cart.transition(before, Cart.Input(1.0), CartParameters())
    np.testing.assert_allclose(result.values[1, :2], predicted)
    np.testing.assert_array_equal(result.values[2, :2], result.values[1, :2])


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ((ContinuousCart, CartParameters(), (0.0, 0.0), FULL.gain), "discretise"),
        ((Cart, CartParameters(), (0.0,), FULL.gain), "initial_mean needs 2"),
        ((Cart, CartParameters(), (0.0, 0.0), ((1.0,), (1.0,))), "expected 2 .position, speed. of 2"),
    ],
)
def test_wrong_tuning_is_refused(fields, words):
    with pytest.raises(ParameterError, match=words):
        Luenberger(*fields)
