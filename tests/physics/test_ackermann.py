import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.ackermann import ackermann_angle, ackermann_slope

TRACK, WHEELBASE = 1.55, 2.83


@pytest.mark.parametrize(("steer", "error"), [(0.1, 0.005), (-0.2, 0.02), (0.35, 0.055), (-0.5, 0.12)])
def test_full_gain_lets_both_wheels_roll_about_one_centre(steer, error):
    """Exact condition: tan of each wheel is wheelbase over radius less or plus half the track."""
    radius = WHEELBASE / math.tan(steer)
    left = math.atan(WHEELBASE / (radius - 0.5 * TRACK))
    right = math.atan(WHEELBASE / (radius + 0.5 * TRACK))
    mean, gain = 0.5 * (left + right), 0.5 * TRACK / WHEELBASE
    difference = ackermann_angle(mean, gain) - ackermann_angle(mean, -gain)
    assert difference == pytest.approx(left - right, rel=error)
    assert 0.5 * (ackermann_angle(mean, gain) + ackermann_angle(mean, -gain)) == pytest.approx(mean)


@given(st.floats(-0.7, 0.7), st.floats(-0.3, 0.3))
def test_slope_is_the_derivative(steer, gain):
    rise = ackermann_angle(steer + 1e-5, gain) - ackermann_angle(steer - 1e-5, gain)
    assert ackermann_slope(steer, gain) == pytest.approx(rise / 2e-5, rel=1e-6)
