"""Choices of outputs, and unknown inputs as states."""

import numpy as np
import pytest

from methods.analysis.column_sets import TORQUES, column
from tierod.core.errors import ParameterError
from tierod.models.linear import LinearSystem
from tierod_lab.papers.column.output_subsets import Sampling, extended, output_subsets, shown_by


def test_constant_torques_become_states():
    system = column()
    larger = extended(system, TORQUES)
    assert larger.states[6:] == TORQUES
    assert larger.inputs == ("motor_torque",)
    x, torques = np.arange(6.0), np.array([0.3, -0.2])
    rate = larger.A @ np.concatenate([x, torques])
    np.testing.assert_allclose(rate[:6], system.A @ x + system.B[:, 1:] @ torques)
    np.testing.assert_array_equal(rate[6:], 0.0)


def test_feed_through_of_a_disturbance_is_seen():
    larger = extended(LinearSystem.of([[-1.0]], [[1.0]], [[1.0, 2.0]], [[3.0, 4.0]]), ["u1"])
    np.testing.assert_array_equal(larger.C, [[1.0, 4.0]])
    np.testing.assert_array_equal(larger.D, [[3.0]])


def test_a_wrong_disturbance_is_refused():
    with pytest.raises(ParameterError, match="did you mean 'hand_torque'"):
        extended(column(), ["hand_torqe"])


SAMPLING = Sampling(
    {"steering_wheel_angle": 8.7e-4, "motor_angle_mechanical": 3.5e-3, "driver_torque": 0.02}, 1e-3, 0.5
)


def test_every_choice_of_outputs_once():
    table = output_subsets(column("S3"), SAMPLING)
    assert len({row.outputs for row in table}) == len(table) == 7
    assert [row.exact.rank for row in table] == [6, 6, 5, 6, 6, 6, 6]
    assert [row.unscaled.rank for row in table] == [6, 6, 4, 6, 6, 6, 6]


def test_bounds_and_conditions_are_better_with_more_outputs():
    system = extended(column(), TORQUES)
    two = shown_by(system, ["steering_wheel_angle", "motor_angle_mechanical"], SAMPLING)
    three = shown_by(system, system.outputs, SAMPLING)
    assert (three.bound.end < two.bound.end).all()
    assert three.condition < two.condition


def test_one_angle_cannot_distinguish_the_torques():
    row = shown_by(extended(column(), TORQUES), ["motor_angle_mechanical"], SAMPLING)
    assert row.ranks == {
        "staircase": 7, "PBH": 7, "scaled matrix": 7, "sampled matrix": 7, "unscaled matrix": 5
    }  # fmt: skip
    assert np.isinf(row.bound["hand_torque"])


def test_no_output_shows_nothing():
    assert set(shown_by(column(), [], SAMPLING).ranks.values()) == {0}


def test_too_many_outputs_are_refused():
    with pytest.raises(ParameterError, match="too many choices"):
        output_subsets(LinearSystem.of([[-1.0]], np.ones((9, 1))), SAMPLING)
