from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from models.friction_paper import CAR
from tierod.core.graph import jacobian
from tierod_lab.papers.friction.joint_model import FrictionEstimation, rate_hold

ZERO = FrictionEstimation.State(0.0, 0.0, 0.0, 0.0, 0.0)


def transition_matrix(direction: float) -> np.ndarray:
    at = FrictionEstimation.Input(0.0, 0.0, 0.0, direction)
    return np.array(jacobian(lambda x: FrictionEstimation.transition(x, at, CAR), ZERO))


def input_matrix() -> np.ndarray:
    at = FrictionEstimation.Input(0.0, 0.0, 0.0, 1.0)
    return np.array(jacobian(lambda u: FrictionEstimation.transition(ZERO, u, CAR), at))[:, :3]


def test_transition_matrix_of_equation_7_with_the_numbers_of_the_midsize_car():
    decay, gain = math.exp(-0.08), (1.0 - math.exp(-0.08)) / 0.8
    expected = np.array(
        [
            [1.0, 0.01, 0.0, 0.0, 0.0],
            [0.0, decay, 0.0, -gain / 15.5, -gain],
            [0.0, 0.0, 1.0, 0.01 * 2.83 / (0.05 * 2800.0), 0.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ]
    )
    matrix = transition_matrix(1.0)
    assert matrix == pytest.approx(expected, abs=1e-12)
    assert matrix[2, 3] == pytest.approx(2.0214e-4, abs=1e-8)
    assert transition_matrix(-1.0)[1, 4] == -matrix[1, 4]
    assert transition_matrix(0.0)[1, 4] == 0.0


def test_input_matrix_of_equation_8_with_the_numbers_of_the_midsize_car():
    matrix = input_matrix()
    expected = np.zeros((5, 3))
    expected[1, :2] = matrix[1, 0] * np.array([1.0, 20.0])
    expected[2, 2] = -0.01 * 1.69 * 1600.0 / 2800.0
    assert matrix == pytest.approx(expected, abs=1e-12)
    assert matrix[1, 0] == pytest.approx(0.096105, abs=1e-6)
    assert matrix[2, 2] == pytest.approx(-9.6571e-3, abs=1e-6)


@given(st.floats(1e-4, 0.1), st.floats(1e-9, 20.0), st.floats(0.01, 5.0))
def test_rate_hold_is_the_matrix_exponential(sample_time, damping, inertia):
    system = np.array([[-damping / inertia, 1.0 / inertia], [0.0, 0.0]])
    exact = expm(system * sample_time)
    decay, gain = rate_hold(sample_time, damping, inertia)
    assert decay == pytest.approx(exact[0, 0], rel=1e-10)
    assert gain == pytest.approx(exact[0, 1], rel=1e-8)
