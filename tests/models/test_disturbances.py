"""Unknown inputs and offsets as states of a linear system."""

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.models.column_observation import with_disturbance_states, with_offset_state, with_outputs
from tierod.models.linear import LinearSystem, sampled


def system():
    rng = np.random.default_rng(0)
    return LinearSystem(
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        ("x0", "x1"),
        ("known", "first", "second"),
        ("y0", "y1"),
    )


def test_disturbances_move_from_inputs_to_states():
    plain = system()
    found = with_disturbance_states(plain, {"second": 2, "first": 1})
    assert found.states == ("x0", "x1", "second", "second_rate", "first")
    assert found.inputs == ("known",)
    x, u = np.array([1.0, -2.0, 0.7, 0.3, -0.5]), np.array([0.9])
    full = np.array([0.9, -0.5, 0.7])
    expected = [*(plain.A @ x[:2] + plain.B @ full), 0.3, 0.0, 0.0]
    np.testing.assert_allclose(found.A @ x + found.B @ u, expected)
    np.testing.assert_allclose(found.C @ x + found.D @ u, plain.C @ x[:2] + plain.D @ full)


def test_a_walk_of_second_order_is_a_ramp_without_noise():
    discrete = sampled(with_disturbance_states(system(), {"first": 2}), 0.1)
    x = np.array([0.0, 0.0, 1.0, 2.0])
    for _ in range(5):
        x = discrete.A @ x
    np.testing.assert_allclose(x[2:], [2.0, 2.0])


def test_an_offset_is_added_to_its_output_and_stays():
    plain = system()
    found = with_offset_state(plain, "y1", "offset")
    x = np.array([1.0, -2.0, 0.3])
    np.testing.assert_allclose(found.C @ x - plain.C @ x[:2], [0.0, 0.3])
    assert (found.A @ x)[2] == 0.0
    assert found.states[-1] == "offset"


def test_outputs_in_another_order():
    found = with_outputs(system(), ("y1",))
    np.testing.assert_allclose(found.C, system().C[1:])
    assert found.outputs == ("y1",)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: with_disturbance_states(system(), {"frist": 1}), "did you mean 'first'"),
        (lambda: with_disturbance_states(system(), {"first": 4}), "expected 1 to 3"),
        (lambda: with_offset_state(system(), "y2", "offset"), "no output 'y2'"),
        (lambda: with_outputs(system(), ("y2",)), "no output 'y2'"),
    ],
)
def test_refused(call, words):
    with pytest.raises(ParameterError, match=words):
        call()
