"""Torque of a motor beside its target: what the voltage leaves at a speed, and what varies with the rotor's angle."""

import math

import numpy as np
import pytest

from tierod_lab.ground.steering.motor_torque import driving_limit, torque_ripple


@pytest.mark.parametrize(
    ("speed", "torque"), [(-300.0, 3.0), (0.0, 3.0), (150.0, 3.0), (250.0, 1.5), (350.0, 0.0), (500.0, 0.0)]
)
def test_torque_falls_between_base_and_no_load_speed(speed, torque):
    assert driving_limit(speed, 3.0, 150.0, 350.0) == pytest.approx(torque)


def test_ripple_has_its_order_and_grows_with_the_torque():
    angle = np.linspace(0.0, 2.0 * math.pi, 1000, endpoint=False)
    ripple = torque_ripple(angle, 2.0, 0.01, 0.02, 24.0)
    spectrum = np.abs(np.fft.rfft(ripple)) / 500.0
    assert np.argmax(spectrum) == 24
    assert spectrum[24] == pytest.approx(0.05)
    assert abs(np.mean(ripple)) < 1e-12
