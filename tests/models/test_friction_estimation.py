"""friction_estimation"""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from models.friction_paper import CAR
from tierod.core.graph import jacobian
from tierod.models.friction_estimation import (
    FrictionEstimation,
    SmoothFrictionEstimation,
    SmoothFrictionParameters,
    driving_torque,
    rate_hold,
)

ZERO = FrictionEstimation.State(0.0, 0.0, 0.0, 0.0, 0.0)
SMOOTH = SmoothFrictionParameters(**dataclasses.asdict(CAR), smoothing_rate=0.02)


def transition_matrix(direction: float) -> np.ndarray:
    at = FrictionEstimation.Input(0.0, 0.0, 0.0, direction)
    return np.array(jacobian(lambda x: FrictionEstimation.transition(x, at, CAR), ZERO))


def input_matrix() -> np.ndarray:
    at = FrictionEstimation.Input(0.0, 0.0, 0.0, 1.0)
    return np.array(jacobian(lambda u: FrictionEstimation.transition(ZERO, u, CAR), at))[:, :3]


def observability_rank(direction: float, outputs: tuple[int, ...]) -> int:
    system, measured = transition_matrix(direction), np.eye(5)[list(outputs)]
    stacked = np.vstack([measured @ np.linalg.matrix_power(system, k) for k in range(5)])
    return int(np.linalg.matrix_rank(stacked / np.linalg.norm(stacked, axis=0).clip(1e-300), tol=1e-10))


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


@pytest.mark.parametrize(
    ("direction", "outputs", "rank"),
    [(1.0, (0, 1, 2), 5), (-1.0, (0, 1, 2), 5), (0.0, (0, 1, 2), 4), (1.0, (0, 1), 3)],
)
def test_observability_ranks(direction, outputs, rank):
    assert observability_rank(direction, outputs) == rank


def test_the_smooth_model_is_the_linear_one_away_from_standstill():
    inputs = FrictionEstimation.Input(2.0, 0.3, 1.0, 1.0)
    for rate, direction in ((0.5, 1.0), (-0.5, -1.0)):
        state = FrictionEstimation.State(0.3, rate, 0.1, 40.0, 4.0)
        linear = FrictionEstimation.transition(state, inputs._replace(direction=direction), CAR)
        smooth = SmoothFrictionEstimation.transition(state, inputs, SMOOTH)
        assert smooth == pytest.approx(linear, abs=1e-12)
        assert SmoothFrictionEstimation.output(state, inputs, SMOOTH) == (0.3, rate, 0.1)


def test_the_smooth_model_has_no_friction_at_standstill():
    inputs = FrictionEstimation.Input(0.0, 0.0, 0.0, 1.0)
    state = FrictionEstimation.State(0.0, 0.0, 0.0, 0.0, 4.0)
    assert SmoothFrictionEstimation.transition(state, inputs, SMOOTH).steering_wheel_rate == 0.0


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
