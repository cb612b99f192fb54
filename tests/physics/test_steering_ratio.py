import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import steering_ratio as gear


@given(st.floats(-10, 10), st.floats(0, 0.01))
def test_ratio_is_the_slope_of_the_angle(angle, growth):
    step = 1e-4
    rise = gear.road_wheel_angle(angle + step, 0.065, growth) - gear.road_wheel_angle(angle - step, 0.065, growth)
    assert rise / (2.0 * step) == pytest.approx(gear.variable_ratio(angle, 0.065, growth), rel=1e-6)


def test_torques_across_gears():
    assert gear.torque_at_steering_wheel(155.0, 1.0 / 15.5) == pytest.approx(10.0)
    assert gear.column_torque_of_motor(0.5, 20.0) == 10.0
