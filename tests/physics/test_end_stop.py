import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.end_stop import end_stop_torque

STOP = {"lock": 8.5, "stiffness": 400.0, "damping": 5.0}


def test_both_sides_push_back_beyond_the_lock_only():
    assert end_stop_torque(8.6, 0.0, **STOP) == pytest.approx(40.0)
    assert end_stop_torque(-8.6, 0.0, **STOP) == pytest.approx(-40.0)
    assert end_stop_torque(8.6, 1.0, **STOP) == pytest.approx(45.0)
    assert end_stop_torque(8.5, 3.0, **STOP) == 0.0
    assert end_stop_torque(-8.4, -3.0, **STOP) == 0.0


@given(st.floats(-12, 12), st.floats(-20, 20))
def test_a_stop_never_pulls(angle, rate):
    assert end_stop_torque(angle, rate, **STOP) * angle >= 0.0
