import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled
from tierod_lab.methods.pole_placement import discrete_poles, observer_gain, place


def closed(system, gain):
    return (np.eye(len(system.A)) - np.array(gain) @ system.C) @ system.A


def assert_poles(matrix, poles, rtol=1e-5):
    np.testing.assert_allclose(np.poly(matrix), np.poly(np.array(poles)).real, rtol=rtol, atol=1e-7)


def observable(seed, n, outputs):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    return LinearSystem.of(A, rng.normal(size=(outputs, n)))


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.integers(1, 5), st.integers(1, 3), st.booleans())
def test_poles_are_the_requested_ones(seed, n, outputs, pair):
    system = observable(seed, n, min(outputs, n))
    poles = np.linspace(0.2, 0.7, n).astype(complex)
    if pair and n > 1:
        poles[:2] = 0.4 + 0.3j, 0.4 - 0.3j
    assert_poles(closed(system, observer_gain(system, poles)), poles)


@pytest.mark.parametrize("outputs", [1, 2])
def test_triple_pole(outputs):
    continuous = LinearSystem.of([[0, 1, 0], [0, -8, 10], [0, 0, 0]], np.eye(outputs, 3))
    system = sampled(continuous, 0.01)
    poles = discrete_poles((-15.0,) * 3, 0.01)
    assert poles == pytest.approx([np.exp(-0.15)] * 3)
    assert_poles(closed(system, observer_gain(system, poles)), poles)


def test_repeated_complex_pairs_through_two_outputs():
    system = observable(3, 6, 2)
    poles = [0.5 + 0.2j, 0.5 - 0.2j] * 3
    assert_poles(closed(system, observer_gain(system, poles)), poles, rtol=1e-4)


def test_a_system_of_integrators_has_equal_poles_too():
    system = LinearSystem.of(np.eye(2), np.eye(2))
    assert_poles(system.A - place(system, (0.5, 0.5)) @ system.C, (0.5, 0.5))


def test_order_of_magnitude_of_units_does_not_matter():
    system = observable(5, 4, 1)
    scale = np.diag([1e6, 1.0, 1e-6, 1e3])
    scaled = LinearSystem.of(scale @ system.A @ np.linalg.inv(scale), 1e-4 * system.C @ np.linalg.inv(scale))
    poles = (0.1, 0.2, 0.3, 0.4)
    assert_poles(closed(scaled, observer_gain(scaled, poles)), poles, rtol=1e-4)


def test_an_output_that_shows_nothing_gets_no_gain():
    gain = place(LinearSystem.of([[1.0, 0.1], [0.0, 1.0]], [[1.0, 0.0], [0.0, 0.0]]), (0.5, 0.5))
    np.testing.assert_allclose(gain, [[1.0, 0.0], [2.5, 0.0]], atol=1e-9)


HIDDEN = LinearSystem.of(np.diag([0.9, 0.8, 0.7]), [[1.0, 0.0, 1.0]], states=("angle", "bias", "rate"))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: observer_gain(HIDDEN, (0.1, 0.2, 0.3)), "the direction 1 bias .eigenvalue 0.8. is not observable"),
        (lambda: observer_gain(HIDDEN, (0.1, 0.2)), "2 poles for 3 states"),
        (lambda: observer_gain(HIDDEN, (0.1, 0.2, 0.3j)), "not in complex pairs"),
        (lambda: observer_gain(HIDDEN, (0.1, 0.2, np.nan)), "not all finite"),
    ],
)
def test_what_cannot_be_placed_is_refused_with_its_name(call, words):
    with pytest.raises(ParameterError, match=words):
        call()
