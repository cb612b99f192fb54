import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.assist import active_return_share, active_return_torque, assist_speed_factor, assist_torque

CHART = {"linear_gain": 2.0, "quadratic_gain": 1.5, "dead_band": 0.3, "half_speed": 15.0, "maximum_torque": 60.0}


@given(st.floats(-20, 20), st.floats(0, 60))
def test_assist_helps_the_driver_within_the_limit_and_is_odd(torque, speed):
    assist = assist_torque(torque, speed, **CHART)
    assert abs(assist) <= 60.0
    assert assist * torque >= 0.0
    assert assist_torque(-torque, speed, **CHART) == -assist


def test_assist_rises_with_torque_and_falls_with_speed():
    torques = np.linspace(0.0, 10.0, 200)
    assert np.all(np.diff(assist_torque(torques, 10.0, **CHART)) >= 0.0)
    assert assist_torque(3.0, 5.0, **CHART) > assist_torque(3.0, 30.0, **CHART)
    assert assist_torque(0.3, 0.0, **CHART) == 0.0
    assert assist_torque(10.0, 0.0, **CHART) == 60.0


def test_half_speed_halves():
    assert assist_speed_factor(0.0, 15.0) == 1.0
    assert assist_speed_factor(15.0, 15.0) == 0.5


def test_active_return_pulls_to_the_middle_at_a_wanted_rate():
    assert active_return_torque(1.0, 0.0, 1.5, 3.0, 2.0) == pytest.approx(-3.0)
    assert active_return_torque(1.0, -1.5, 1.5, 3.0, 2.0) == pytest.approx(0.0)
    assert active_return_torque(-8.0, 0.0, 1.5, 3.0, 2.0) == pytest.approx(6.0)


def test_active_return_is_given_when_rolling_and_released():
    speeds = np.linspace(0.0, 40.0, 401)
    shares = active_return_share(speeds, 0.0, 6.0, 1.0)
    assert shares[0] == 0.0
    assert speeds[np.argmax(shares)] == pytest.approx(6.0)
    assert np.max(shares) == pytest.approx(1.0)
    assert active_return_share(6.0, -1.0, 6.0, 1.0) == pytest.approx(0.5)
