"""Steering from wheel to road wheels: the ratio between them, Ackermann's angles, and the torsion bar that measures.

A ratio here is road-wheel angle per steering-wheel angle (about 1/15), the rho of Mohtat et al., eq (2). By virtual
work the same number turns a torque about the kingpin into a torque at the steering wheel.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import steering_ratio as gear
from tierod.physics.steering_ratio import (
    ackermann_angle,
    ackermann_slope,
    pinion_angle,
    torsion_bar_torque,
    torsion_bar_twist,
)


@given(st.floats(-10, 10), st.floats(0, 0.01))
def test_ratio_is_the_slope_of_the_angle(angle, growth):
    step = 1e-4
    rise = gear.road_wheel_angle(angle + step, 0.065, growth) - gear.road_wheel_angle(angle - step, 0.065, growth)
    assert rise / (2.0 * step) == pytest.approx(gear.variable_ratio(angle, 0.065, growth), rel=1e-6)


def test_torques_across_gears():
    assert gear.torque_at_steering_wheel(155.0, 1.0 / 15.5) == pytest.approx(10.0)
    assert gear.column_torque_of_motor(0.5, 20.0) == 10.0


TRACK, WHEELBASE = 1.55, 2.83


@pytest.mark.parametrize(("steer", "error"), [(0.1, 0.005), (-0.2, 0.02), (0.35, 0.055), (-0.5, 0.12)])
def test_full_gain_lets_both_wheels_roll_about_one_centre(steer, error):
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


def test_bar_pulls_the_pinion_after_the_wheel():
    assert torsion_bar_torque(0.02, 0.0, 140.0) == pytest.approx(2.8)
    assert torsion_bar_torque(0.0, 0.0, 140.0, 1.0, 0.0, 0.05) == pytest.approx(0.05)


def test_twist_inverts_the_torque_at_rest():
    assert torsion_bar_twist(torsion_bar_torque(0.03, 0.01, 140.0), 140.0) == pytest.approx(0.02)


@pytest.mark.parametrize("growth", [-0.05, 0.0, 1e-13, 0.06, 0.4])
@pytest.mark.parametrize("angle", [-2.5, -0.3, 0.0, 1.0, 2.5])
def test_the_pinion_angle_is_the_root_of_the_cubic(angle, growth):
    steer = angle / 15.5 * (1.0 + growth / 3.0 * angle * angle)
    assert pinion_angle(steer, 1.0 / 15.5, growth) == pytest.approx(angle, abs=1e-9)
    roots = np.roots([growth / 3.0, 0.0, 1.0, -15.5 * steer]) if growth else np.array([15.5 * steer])
    near = roots[np.argmin(np.abs(roots - angle))]
    assert pinion_angle(steer, 1.0 / 15.5, growth) == pytest.approx(near.real, abs=1e-9)
