from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tierod.models.eps_column import EpsColumn, driving_torque, rate_hold

COLUMN = EpsColumn.Parameters(
    column_inertia=0.1, column_damping=0.8, nominal_friction=4.0, motor_ratio=20.0, steering_ratio=1.0 / 15.5
)


def test_rate_hold_numbers_of_the_midsize_car():
    decay, gain = rate_hold(0.01, 0.8, 0.1)
    assert decay == pytest.approx(0.92312, abs=5e-6)
    assert decay == pytest.approx(math.exp(-0.08), abs=1e-15)
    assert gain == pytest.approx(0.096105, abs=1e-6)


@given(st.floats(1e-4, 0.1), st.floats(1e-9, 20.0), st.floats(0.01, 5.0))
def test_rate_hold_is_the_matrix_exponential(sample_time, damping, inertia):
    system = np.array([[-damping / inertia, 1.0 / inertia], [0.0, 0.0]])
    exact = expm(system * sample_time)
    decay, gain = rate_hold(sample_time, damping, inertia)
    assert decay == pytest.approx(exact[0, 0], rel=1e-10)
    assert gain == pytest.approx(exact[0, 1], rel=1e-8)


def test_without_damping_the_gain_is_time_over_inertia():
    assert rate_hold(0.01, 1e-12, 0.1)[1] == pytest.approx(0.1, rel=1e-9)


def test_three_roads_to_the_rate_meet():
    torques = EpsColumn.Input(3.0, 0.4, 50.0)
    net = driving_torque(*torques, COLUMN) - COLUMN.nominal_friction
    closed = net / 0.8 * (1.0 - math.exp(-8.0 * 0.5))
    rate = 0.0
    decay, gain = rate_hold(0.01, 0.8, 0.1)
    for _ in range(50):
        rate = decay * rate + gain * net
    simulated = solve_ivp(
        lambda _, x: EpsColumn.derivative(EpsColumn.State(*x), torques, COLUMN), (0.0, 0.5), [0.0, 1e-9], rtol=1e-9
    ).y[1, -1]
    assert rate == pytest.approx(closed, rel=1e-12)
    assert simulated == pytest.approx(closed, rel=1e-6)


@pytest.mark.parametrize(("rate", "opposed"), [(2.0, -4.0 - 1.6), (-2.0, 4.0 + 1.6), (0.0, 0.0)])
def test_friction_and_damping_oppose_the_motion(rate, opposed):
    still = EpsColumn.Input(0.0, 0.0, 0.0)
    change = EpsColumn.derivative(EpsColumn.State(1.0, rate), still, COLUMN)
    assert change == (rate, pytest.approx(opposed / 0.1))
    assert EpsColumn.output(EpsColumn.State(1.0, rate), still, COLUMN) == (1.0, rate)


def test_motor_torque_is_geared_once_and_tyres_resist():
    assert driving_torque(1.0, 0.5, 31.0, COLUMN) == pytest.approx(1.0 + 20.0 * 0.5 - 2.0)
