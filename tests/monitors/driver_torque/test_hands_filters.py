import numpy as np
import pytest

from tierod.monitors.driver_torque.hands import WheelAcceleration, WheelRate

STEP = 1e-3


def followed(rate):
    """Acceleration [rad/s^2] given after every sample of a rate [rad/s]."""
    block = WheelAcceleration.at(STEP)
    state, found = block.init(), []
    for value in rate:
        state, output = block.step(state, WheelRate(float(value)))
        found.append(output.steering_wheel_acceleration)
    return np.array(found)


def test_a_ramp_is_followed_exactly():
    assert followed(3.0 * np.arange(200) * STEP)[-1] == pytest.approx(3.0, rel=1e-6)


def test_at_three_hertz_it_is_hardly_late():
    time, turn = np.arange(2000) * STEP, 2.0 * np.pi * 3.0
    result = followed(np.sin(turn * time))
    there = turn * np.cos(turn * (time + 0.5 * STEP))
    assert np.max(np.abs(result - there)[200:]) < 0.03 * turn
