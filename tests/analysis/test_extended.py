import numpy as np
import pytest

from analysis.column_sets import TORQUES, column
from tierod.analysis.extended import extended, through
from tierod.errors import ParameterError
from tierod.models.linear import LinearSystem, sampled


def test_constant_torques_become_states():
    system = column()
    larger = extended(system, TORQUES)
    assert larger.states[6:] == TORQUES
    assert larger.inputs == ("motor_torque",)
    x, torques = np.arange(6.0), np.array([0.3, -0.2])
    rate = larger.A @ np.concatenate([x, torques])
    np.testing.assert_allclose(rate[:6], system.A @ x + system.B[:, 1:] @ torques)
    np.testing.assert_array_equal(rate[6:], 0.0)


def test_extending_and_sampling_commute():
    system = column()
    first = sampled(extended(system, TORQUES), 1e-3)
    then = extended(sampled(system, 1e-3), TORQUES, discrete=True)
    np.testing.assert_allclose(first.A, then.A, atol=1e-12)
    np.testing.assert_allclose(first.B, then.B, atol=1e-12)


def test_feed_through_of_a_disturbance_is_seen():
    system = LinearSystem.of([[-1.0]], [[1.0]], [[1.0, 2.0]], [[3.0, 4.0]])
    larger = extended(system, ["u1"])
    np.testing.assert_array_equal(larger.C, [[1.0, 4.0]])
    np.testing.assert_array_equal(larger.D, [[3.0]])


def test_outputs_are_chosen_in_any_order():
    part = through(column(), ["driver_torque", "steering_wheel_angle"])
    np.testing.assert_array_equal(part.C, column().C[[2, 0]])
    assert part.outputs == ("driver_torque", "steering_wheel_angle")


@pytest.mark.parametrize("names", [["hand_torqe"], ["hand_torque", "hand_torque"]])
def test_wrong_disturbances_are_refused(names):
    with pytest.raises(ParameterError, match="hand_torque"):
        extended(column(), names)
    with pytest.raises(ParameterError, match="did you mean 'driver_torque'"):
        through(column(), ["driver_torqe"])
