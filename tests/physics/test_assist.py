import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.assist import assist_speed_factor, assist_torque

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
