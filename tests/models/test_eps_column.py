from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from tierod.models.friction_estimation import driving_torque, rate_hold


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


def test_motor_torque_is_geared_once_and_tyres_resist():
    assert driving_torque(
        1.0, 0.5, 31.0, SimpleNamespace(motor_ratio=20.0, steering_ratio=1.0 / 15.5)
    ) == pytest.approx(1.0 + 20.0 * 0.5 - 2.0)
