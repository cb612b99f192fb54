"""Observability by staircase, PBH test and matrix."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from example_models import Pendulum, PendulumParameters
from methods.analysis.column_sets import TORQUES, column
from tierod.core.errors import ParameterError
from tierod.methods.analysis.observability import observability
from tierod.models.column_observation import with_outputs
from tierod.models.linear import LinearSystem, linearise, sampled
from tierod_lab.methods.ranks import default_rank, observability_matrix, pbh_rank, scaled_rank, unscaled_rank
from tierod_lab.papers.column.columns import EIGENVALUES, SETS, extended


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
    assert "every state is observable" in observability(friction_system(1.0)).sentence()
    assert observability(friction_system(0.0)).sentence().endswith("not observable: 1 friction")
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
    modes = np.linalg.eigvals(A[:seen, :seen])
    tests = [np.vstack([mode * np.eye(seen) - A[:seen, :seen], C[:, :seen]]) for mode in modes]
    assume(min(np.linalg.svd(each, compute_uv=False)[-1] for each in tests) > 1e-3)  # Popov, Belevitch, Hautus
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
    hanging = observability(linearise(Pendulum, PendulumParameters(), (0.0, 0.0), (0.0,)))
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


WHEEL, MOTOR, BAR = "steering_wheel_angle", "motor_angle_mechanical", "driver_torque"


@pytest.mark.parametrize("name", SETS)
def test_eigenvalues_are_those_of_the_table(name):
    found = np.sort_complex(np.linalg.eigvals(column(name).A))
    np.testing.assert_allclose(found, np.sort_complex(np.array(EIGENVALUES)), rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize(
    ("outputs", "exact"),
    [((MOTOR,), 6), ((WHEEL,), 6), ((WHEEL, MOTOR), 6), ((BAR,), 5), ((BAR, MOTOR), 6), ((BAR, WHEEL), 6)],
)
def test_exact_ranks_of_the_column(name, outputs, exact):
    system = with_outputs(column(name), outputs)
    assert observability(system).rank == exact
    assert scaled_rank(system) == exact
    assert unscaled_rank(sampled(system, 1e-3)) == exact
    assert pbh_rank(system) == exact


@pytest.mark.parametrize(
    ("outputs", "printed"), [((BAR,), 4), ((WHEEL, MOTOR), 6), ((BAR, MOTOR), 6), ((BAR, WHEEL), 6)]
)
def test_ranks_of_the_paper_in_double_precision(outputs, printed):
    assert unscaled_rank(with_outputs(column("S3"), outputs)) == printed


@pytest.mark.parametrize("name", SETS)
def test_with_disturbances_the_unscaled_matrix_says_five_of_eight_and_every_other_method_eight(name):
    system = extended(column(name), TORQUES)
    assert unscaled_rank(system) == 5
    assert scaled_rank(system) == observability(system).rank == pbh_rank(system) == 8
    assert [unscaled_rank(sampled(system, step)) for step in (1e-4, 1e-3, 1e-2)] == [8, 8, 8]


def test_the_matrix_itself():
    system = LinearSystem.of([[0.0, 1.0], [-2.0, -3.0]], [[1.0, 0.0]])
    np.testing.assert_array_equal(observability_matrix(system.A, system.C), [[1.0, 0.0], [0.0, 1.0]])


def test_the_default_tolerance_is_the_side_times_the_spacing():
    tolerance = 3.0 * 2.0**-52
    assert default_rank(np.diag([1.0, 1.01 * tolerance, 0.99 * tolerance])) == 2


def test_units_move_the_unscaled_rank_alone():
    slow = LinearSystem.of([[0.0, 1e-9], [0.0, 0.0]], [[1.0, 0.0]])
    fast = LinearSystem.of([[0.0, 1e-18], [0.0, 0.0]], [[1.0, 0.0]])
    assert unscaled_rank(slow) == 2
    assert unscaled_rank(fast) == 1
    assert scaled_rank(fast) == pbh_rank(fast) == 2


def test_hidden_eigenvectors_are_counted_once_each():
    two = LinearSystem.of(np.diag([-1.0, -1.0, -2.0]), [[0.0, 0.0, 1.0]])
    assert pbh_rank(two) == observability(two).rank == 1
    chain = LinearSystem.of([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]], [[0.0, 0.0, 1.0]])
    assert pbh_rank(chain) == 2
    assert observability(chain).rank == 1
