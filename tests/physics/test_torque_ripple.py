import math

import numpy as np
import pytest

from tierod.physics.torque_ripple import torque_ripple


def test_ripple_has_its_order_and_grows_with_the_torque():
    angle = np.linspace(0.0, 2.0 * math.pi, 1000, endpoint=False)
    ripple = torque_ripple(angle, 2.0, 0.01, 0.02, 24.0)
    spectrum = np.abs(np.fft.rfft(ripple)) / 500.0
    assert np.argmax(spectrum) == 24
    assert spectrum[24] == pytest.approx(0.05)
    assert abs(np.mean(ripple)) < 1e-12
