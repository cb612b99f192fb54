import control
import numpy as np
import pytest

from methods.analysis.column_sets import column
from tierod.core.errors import ParameterError
from tierod.methods.analysis.frequency_response import decibels, frequency_response, largest_difference, phase
from tierod.models.linear import LinearSystem, sampled

FREQUENCY = np.geomspace(0.1, 300.0, 60)


def test_a_first_order_lag_in_closed_form():
    lag = LinearSystem.of([[-5.0]], [[1.0]], [[5.0]])
    gain = frequency_response(lag, FREQUENCY).of("y0", "u0")
    np.testing.assert_allclose(gain, 1.0 / (1.0 + 2j * np.pi * FREQUENCY / 5.0))
    corner = frequency_response(lag, 5.0 / (2.0 * np.pi)).of("y0", "u0")
    assert decibels(corner)[0] == pytest.approx(-3.0103, abs=1e-4)
    assert phase(corner)[0] == pytest.approx(-45.0)


@pytest.mark.parametrize("output", [0, 1, 2])
def test_the_column_as_python_control_sees_it(output):
    system = column()
    found = frequency_response(system, FREQUENCY).gain[:, output, 0]
    peer = control.ss(system.A, system.B, system.C, system.D)
    np.testing.assert_allclose(found, peer(2j * np.pi * FREQUENCY)[output, 0], rtol=1e-8)


def test_a_sampled_system_answers_like_the_held_one():
    lag = LinearSystem.of([[-5.0]], [[1.0]], [[5.0]])
    held = frequency_response(sampled(lag, 1e-3), FREQUENCY[:30], 1e-3).gain
    step = 2j * np.pi * FREQUENCY[:30] * 1e-3
    expected = frequency_response(lag, FREQUENCY[:30]).gain[:, 0, 0] * (1.0 - np.exp(-step)) / step
    np.testing.assert_allclose(held[:, 0, 0], expected, rtol=2e-3)


def test_phase_does_not_jump():
    assert (
        np.abs(np.diff(phase(frequency_response(column(), FREQUENCY).of("driver_torque", "motor_torque")))).max() < 180
    )
    assert np.isnan(phase(np.array([1.0 + 0j, np.nan, 1j]))).tolist() == [False, True, False]


def test_a_gain_that_is_infinite_is_refused():
    with pytest.raises(ParameterError, match="infinite"):
        frequency_response(LinearSystem.of([[0.0]], [[1.0]], [[1.0]]), 0.0)


def test_unknown_names_are_refused():
    with pytest.raises(ParameterError, match="did you mean 'driver_torque'"):
        frequency_response(column(), 1.0).of("driver_torqe", "motor_torque")


def test_the_largest_difference_is_a_singular_value():
    one = LinearSystem.of([[-1.0]], np.zeros((2, 1)), np.zeros((1, 2)), np.diag([3.0, 4.0]))
    other = LinearSystem.of([[-1.0]], np.zeros((2, 1)), np.zeros((1, 2)), np.diag([1.0, -1.0]))
    assert largest_difference(one, other, [1.0, 2.0]) == pytest.approx(5.0)
