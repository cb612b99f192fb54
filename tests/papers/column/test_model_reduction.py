"""Gramians, balanced and modal reduction."""

import math
from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from methods.analysis.column_sets import TORQUES, column
from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem, linearise
from tierod.models.steering_column import ColumnInput, TwoInertiaColumn, without_gear
from tierod_lab.papers.column.columns import EIGENVALUES, SETS, extended
from tierod_lab.papers.column.frequency_response import frequency_response, largest_difference
from tierod_lab.papers.column.model_reduction import (
    balanced,
    balanced_reduction,
    controllability_gramian,
    gramian_condition,
    modal_reduction,
    observability_gramian,
)


@pytest.mark.parametrize("rate", [-2.0, 0.0, 3.0])
def test_one_state_in_closed_form(rate):
    system = LinearSystem.of([[rate]], [[5.0]], [[7.0]])
    over = math.expm1(2.0 * rate * 1.5) / (2.0 * rate) if rate else 1.5
    assert observability_gramian(system, 1.5)[0, 0] == pytest.approx(25.0 * over)
    assert controllability_gramian(system, 1.5)[0, 0] == pytest.approx(49.0 * over)


def test_over_a_time_it_is_the_integral():
    system = column()

    def integrand(t):
        seen = system.C @ expm(system.A * t)
        return seen.T @ seen

    integral = sum(quad_vec(integrand, k * 0.02, (k + 1) * 0.02, epsrel=1e-10)[0] for k in range(5))
    np.testing.assert_allclose(observability_gramian(system, 0.1), integral, rtol=1e-6, atol=1e-9 * integral.max())


def test_all_time_is_the_limit_of_a_stable_system():
    system = LinearSystem.of([[0.0, 1.0], [-4.0, -1.0]], [[1.0, 0.0]], [[0.0], [1.0]])
    np.testing.assert_allclose(observability_gramian(system), observability_gramian(system, 60.0), rtol=1e-9)
    np.testing.assert_allclose(controllability_gramian(system), controllability_gramian(system, 60.0), atol=1e-12)


def test_all_time_is_refused_where_something_does_not_decay():
    with pytest.raises(ParameterError, match="does not decay; give a horizon"):
        observability_gramian(column())
    with pytest.raises(ParameterError, match="horizon is 0"):
        observability_gramian(column(), 0.0)


def test_the_condition_does_not_depend_on_units():
    gramian = observability_gramian(column(), 1.0)
    unit = 10.0 ** np.arange(-3.0, 3.0)
    assert gramian_condition(gramian * np.outer(unit, unit)) == pytest.approx(gramian_condition(gramian), rel=1e-6)
    assert gramian_condition(np.diag([1.0, 1e-9])) == 1.0


def test_what_is_hidden_has_no_condition():
    blind = replace(column(), C=column().C[2:])
    assert gramian_condition(observability_gramian(blind, 1.0)) == math.inf
    assert gramian_condition(np.diag([1.0, 0.0])) == math.inf


FREQUENCY = np.geomspace(1e-3, 1e3, 400)
DEGREE = math.radians(0.1)
SIZES = {
    "input_size": {"hand_torque": 18.0},
    "output_size": {"steering_wheel_angle": DEGREE, "motor_angle_mechanical": 18.0 * DEGREE, "driver_torque": 1.0},
}


def stable(seed=3, n=6):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(n)
    return LinearSystem.of(A, rng.normal(size=(2, n)), rng.normal(size=(n, 2)), rng.normal(size=(2, 2)))


def ordered(matrix):
    return np.sort_complex(np.linalg.eigvals(matrix))


def test_one_state_has_its_hankel_value_in_closed_form():
    form = balanced(LinearSystem.of([[-4.0]], [[3.0]], [[2.0]]))
    assert form.hankel[0] == pytest.approx(3.0 * 2.0 / (2.0 * 4.0))


def test_gramians_of_the_balanced_system_are_alike_and_diagonal():
    form = balanced(stable())
    for A, weight in ((form.system.A, form.system.B), (form.system.A.T, form.system.C.T)):
        np.testing.assert_allclose(control.lyap(A, weight @ weight.T), np.diag(form.hankel), atol=1e-9)
    np.testing.assert_allclose(form.to @ form.back, np.eye(6), atol=1e-9)


def test_hankel_values_are_those_of_the_gramians():
    system = stable()
    reached = control.lyap(system.A, system.B @ system.B.T)
    shown = control.lyap(system.A.T, system.C.T @ system.C)
    values = np.sort(np.sqrt(np.linalg.eigvals(reached @ shown).real))[::-1]
    np.testing.assert_allclose(balanced(system).hankel, values, rtol=1e-6)


@pytest.mark.parametrize(("rest", "method"), [("steady", "matchdc"), ("left out", "truncate")])
def test_reduction_of_a_balanced_system_is_that_of_python_control(rest, method):
    form = balanced(stable()).system
    peer = control.model_reduction(control.ss(form.A, form.B, form.C, form.D), [3, 4, 5], method=method)
    ours = balanced_reduction(stable(), 3, rest=rest).system
    np.testing.assert_allclose(ordered(ours.A), ordered(peer.A), rtol=1e-8)
    np.testing.assert_allclose(ours.D, peer.D, atol=1e-9)
    peers = LinearSystem.of(peer.A, peer.C, peer.B, peer.D)
    assert largest_difference(ours, peers, FREQUENCY) < 1e-8


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("rest", ["steady", "left out"])
def test_the_error_stays_within_its_bound(order, rest):
    found = balanced_reduction(stable(), order, rest=rest)
    assert 0.1 * found.error_bound < largest_difference(stable(), found.system, FREQUENCY) <= found.error_bound


def test_what_is_at_its_steady_state_is_exact_there_and_what_is_left_out_at_high_frequency():
    steady, out = balanced_reduction(stable(), 3), balanced_reduction(stable(), 3, rest="left out")
    assert largest_difference(stable(), steady.system, 0.0) < 1e-9
    assert largest_difference(stable(), out.system, 1e7) < 1e-6
    assert largest_difference(stable(), out.system, 0.0) > 1e-2
    without = balanced_reduction(stable(), 3, feed_through=False)
    assert largest_difference(stable(), without.system, 0.0) > 1e-2
    assert without.error_bound is None


def test_the_balanced_column_keeps_its_slow_modes():
    found = balanced_reduction(column(), 4, **SIZES)
    kept = np.sort_complex(np.array(EIGENVALUES)[2:])
    np.testing.assert_allclose(ordered(found.system.A), kept, atol=1e-4)
    assert np.abs(found.system.D).max() == pytest.approx(0.093, abs=5e-4)
    assert np.abs(found.system.D[2]).max() == np.abs(found.system.D).max()


@pytest.mark.parametrize("shift", [0.1, 1.0, 3.0])
def test_parting_the_free_angle_and_shifting_lead_to_the_same(shift):
    parting, shifted = (balanced_reduction(column(), 4, shift=by, **SIZES).system for by in (None, shift))
    np.testing.assert_allclose(ordered(parting.A), ordered(shifted.A), rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(parting.D, shifted.D, atol=2e-4)


@pytest.mark.parametrize(
    ("spring", "pair"), [("series", -3.79 + 79.24j), ("torsion bar", -3.79 + 81.57j), ("printed", -3.79 + 81.68j)]
)
def test_mechanical_reductions_have_the_published_frequencies(spring, pair):
    parameters = without_gear(SETS["S1"], spring)
    two = linearise(TwoInertiaColumn, parameters, TwoInertiaColumn.State(*[0.0] * 4), ColumnInput(0.0, 0.0, 0.0))
    expected = np.sort_complex(np.array([0.0, -8.11, pair, pair.conjugate()]))
    np.testing.assert_allclose(ordered(two.A), expected, atol=6e-3)


def test_physical_states_come_back():
    system = column()
    found = balanced_reduction(system, 4, **SIZES)
    names = ("motor_speed", "gear_angle")
    full = replace(system, C=np.eye(6)[[1, 5]], D=np.zeros((2, 3)), outputs=names)
    reduced = replace(found.physical(*names, of=system), outputs=("",) * 5)
    low = np.array([0.1, 1.0, 10.0])
    gains = frequency_response(reduced, low).gain[:, 3:]
    np.testing.assert_allclose(gains, frequency_response(full, low).gain, rtol=0.02)


def test_disturbances_as_states_are_kept_whole():
    system = extended(column(), TORQUES)
    found = balanced_reduction(system, 6, **{**SIZES, "input_size": {}})
    np.testing.assert_allclose(ordered(found.system.A)[-1], 0.0, atol=1e-3)
    assert len(found.hankel) == 5
    assert largest_difference(system, found.system, np.geomspace(0.1, 20.0, 50)) < 0.02
    with pytest.raises(ParameterError, match="3 states of the system do not decay"):
        balanced_reduction(system, 2)


def test_what_is_not_reached_or_not_shown_goes_first():
    idle = LinearSystem.of(np.diag([-1.0, -2.0, -3.0]), [[1.0, 1.0, 0.0]], [[1.0], [0.0], [1.0]])
    found = balanced_reduction(idle, 3)
    assert len(found.system.A) == len(found.hankel) == 1
    assert largest_difference(idle, found.system, FREQUENCY) < 1e-12


def test_modes_are_kept_as_they_are():
    found = modal_reduction(column(), 4)
    np.testing.assert_allclose(ordered(found.system.A), np.sort_complex(np.array(EIGENVALUES)[2:]), atol=1e-6)
    assert np.abs(found.system.D).max() == pytest.approx(0.0929, abs=1e-4)
    with pytest.raises(ParameterError, match="split a pair"):
        modal_reduction(column(), 3)
    whole = modal_reduction(column(), 6)
    assert largest_difference(column(), whole.system, np.geomspace(0.1, 1e3, 50)) < 1e-6


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"order": 0}, "order is 0"),
        ({"order": 7}, "expected 1 to 6"),
        ({"rest": "gone"}, "rest is 'gone'"),
        ({"output_size": {"y0": 0.0}}, "size of y0"),
        ({"input_size": {"motor": 1.0}}, "size of motor"),
    ],
)
def test_wrong_settings_are_refused(asked, message):
    with pytest.raises(ParameterError, match=message):
        balanced_reduction(stable(), **{"order": 3} | asked)


def test_a_rest_without_steady_state_is_refused():
    with pytest.raises(ParameterError, match="no steady state"):
        balanced_reduction(LinearSystem.of(np.diag([-1.0, 0.0]), np.eye(2), np.diag([9.0, 0.1])), 1, shift=0.5)
    with pytest.raises(ParameterError, match="does not decay"):
        balanced_reduction(LinearSystem.of([[2.0]], [[1.0]], [[1.0]]), 1, shift=0.5)
    with pytest.raises(ParameterError, match="no state is both controllable and observable"):
        balanced_reduction(LinearSystem.of([[-1.0]], [[1.0]], [[0.0]]), 1)


def test_what_grows_is_kept_whole():
    rising = stable()
    rising = replace(rising, A=rising.A + (0.5 - np.linalg.eigvals(rising.A).real.max()) * np.eye(6))
    growing = [value for value in np.linalg.eigvals(rising.A) if value.real > 0.0]
    found = balanced_reduction(rising, len(growing) + 2)
    kept = np.linalg.eigvals(found.system.A)
    assert all(min(abs(kept - value)) < 1e-9 for value in growing)
    assert largest_difference(rising, found.system, FREQUENCY) <= found.error_bound


def test_forty_states():
    large = stable(seed=8, n=40)
    found = balanced_reduction(large, 12)
    assert largest_difference(large, found.system, FREQUENCY) <= found.error_bound
    assert (np.diff(found.hankel) <= 0.0).all()
    np.testing.assert_allclose(found.onto @ found.back, np.eye(12), atol=1e-6)
