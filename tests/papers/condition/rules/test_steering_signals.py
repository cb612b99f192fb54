import numpy as np
import pytest

from tierod.core.graph import scan
from tierod_lab.papers.condition.rules.steering_signals import SteeringSignals

TIME = np.arange(400) * 0.01


def test_angle_rate_and_acceleration_belong_together():
    angle = 2.0 * np.sin(2.0 * TIME)
    columns = np.stack([angle, angle, 0.0 * angle, 0.0 * angle], axis=1)
    result = scan(SteeringSignals(bandwidth=30.0), columns)
    late = slice(100, None)
    assert result["torque"] == pytest.approx(result["angle"])
    np.testing.assert_allclose(np.gradient(result["angle"], 0.01)[late][1:-1], result["rate"][late][1:-1], atol=0.05)
    delay = 2.0 / 30.0
    expected = -8.0 * np.sin(2.0 * (TIME - delay))
    np.testing.assert_allclose(result["acceleration"][late], expected[late], atol=0.5)


def test_what_is_missing_is_held():
    columns = np.full((300, 4), 1.5)
    columns[200:, 0] = np.nan
    result = scan(SteeringSignals(), columns)
    assert result["angle"][-1] == pytest.approx(1.5, abs=1e-3)
    assert result["rate"][-1] == pytest.approx(0.0, abs=1e-2)
