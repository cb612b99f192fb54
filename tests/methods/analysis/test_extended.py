import numpy as np
import pytest

from methods.analysis.column_sets import TORQUES, column
from tierod.core.errors import ParameterError
from tierod.methods.analysis.extended import extended
from tierod.models.linear import LinearSystem


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
