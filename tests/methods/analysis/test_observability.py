import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from example_models import Pendulum, PendulumParameters
from tierod.core.errors import ParameterError
from tierod.methods.analysis.observability import observability, observability_of
from tierod.models.linear import LinearSystem


def friction_system(direction, outputs=3):
    """Joint filter of motion, aligning torque and friction, Mohtat et al., (7), for the mid-size car."""
    dt, B, J, rho = 0.01, 0.8, 0.10, 1.0 / 15.5
    decay = math.exp(-dt * B / J)
    gain = (1.0 - decay) / B
    A = np.eye(5)
    A[0, 1], A[1, 1], A[1, 3], A[1, 4] = dt, decay, -gain * rho, -gain * direction
    A[2, 3] = dt * (1.69 + 1.14) / (0.050 * 2800.0)
    states = ("angle", "rate", "yaw_rate", "aligning_torque", "friction")
    return LinearSystem.of(A, np.eye(3, 5)[:outputs], states=states)


@pytest.mark.parametrize(("direction", "outputs", "rank"), [(1.0, 3, 5), (-1.0, 3, 5), (0.0, 3, 4), (1.0, 2, 3)])
def test_ranks_of_the_friction_model(direction, outputs, rank):
    system = friction_system(direction, outputs)
    found = observability(system)
    assert found.rank == rank
    assert found.complete == (rank == 5)
    assert found.hidden.shape == (5, 5 - rank)
    powers = np.vstack([system.C @ np.linalg.matrix_power(system.A, k) for k in range(5)])
    np.testing.assert_allclose(powers @ found.hidden, 0.0, atol=1e-9)
    assert np.linalg.matrix_rank(powers) == rank


def test_sentences_name_what_is_hidden():
    assert "show every state" in observability(friction_system(1.0)).sentence()
    assert observability(friction_system(0.0)).sentence().endswith("do not show 1 friction")
    two = observability(friction_system(1.0, 2)).sentence()
    assert "1 yaw_rate" in two
    assert "1 aligning_torque - 0.065 friction" in two


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(0, 3), st.integers(1, 2))
def test_rank_of_systems_built_with_hidden_states(seed, seen, hidden, outputs):
    rng = np.random.default_rng(seed)
    n = seen + hidden
    A = rng.normal(size=(n, n))
    A[:seen, seen:] = 0.0
    C = np.hstack([rng.normal(size=(outputs, seen)), np.zeros((outputs, hidden))])
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0] * 10.0 ** rng.uniform(-2, 2, n)
    system = LinearSystem.of(turn @ A @ np.linalg.inv(turn), C @ np.linalg.inv(turn))
    found = observability(system)
    assert found.rank == seen
    if hidden:
        null = turn[:, seen:]
        projected = null @ np.linalg.lstsq(null, found.hidden, rcond=None)[0]
        np.testing.assert_allclose(projected, found.hidden, atol=1e-5)
        assert found.modes[0].margin < 1e-6


def test_tolerance_decides_where_the_margin_is_small():
    system = LinearSystem.of([[0.9, 1e-5], [0.0, 0.5]], [[1.0, 0.0]])
    given_scale = np.ones(2)
    assert observability(system, state_scale=given_scale).rank == 2
    assert observability(system, tolerance=1e-3, state_scale=given_scale).rank == 1
    assert observability(system, state_scale=given_scale).singular_values[1] == pytest.approx(1e-5 / 0.2, rel=0.3)


def test_any_model_at_a_point():
    hanging = observability_of(Pendulum, PendulumParameters(), (0.0, 0.0), (0.0,))
    assert hanging.complete
    assert hanging.states == ("angle", "rate")


def test_no_output_that_moves_shows_nothing():
    found = observability(replace(friction_system(1.0), C=np.zeros((1, 5))))
    assert found.rank == 0
    np.testing.assert_allclose(np.abs(np.linalg.det(found.hidden)), 1.0)


@pytest.mark.parametrize("arguments", [{"tolerance": 0.0}, {"state_scale": (1.0,)}, {"state_scale": (0.0,) * 5}])
def test_wrong_settings_are_refused(arguments):
    with pytest.raises(ParameterError):
        observability(friction_system(1.0), **arguments)
