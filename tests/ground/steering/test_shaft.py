import math

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.steering.shaft import Motor, Ripple, SpeedLimit


def test_torque_follows_the_request_with_the_lag_and_keeps_the_limit():
    motor = Motor(lag=2e-3, maximum_torque=3.0)
    assert motor.torque_rate(0.0, 2.0) == pytest.approx(1000.0)
    assert motor.torque_rate(3.0, 9.0) == 0.0
    assert motor.torque_rate(-3.0, -9.0) == 0.0


def test_ripple_adds_to_the_shaft():
    motor = Motor(ripple=Ripple(0.02, 0.01, 24.0))
    quarter = 0.5 * math.pi / 24.0
    assert motor.shaft_torque(0.0, quarter) == pytest.approx(0.02)
    assert motor.shaft_torque(2.0, quarter) == pytest.approx(2.04)
    assert Motor().shaft_torque(2.0, quarter) == 2.0


def test_voltage_limits_driving_but_not_braking():
    motor = Motor(lag=1e-3, maximum_torque=3.0, speed_limit=SpeedLimit(150.0, 350.0))
    assert motor.torque_rate(0.0, 9.0, 250.0) == pytest.approx(1500.0)
    assert motor.torque_rate(0.0, -9.0, 250.0) == pytest.approx(-3000.0)
    assert motor.torque_rate(0.0, -9.0, -400.0) == 0.0


def test_a_motor_turns_faster_without_load():
    with pytest.raises(ParameterError, match="not above its base speed of 350 rad/s"):
        SpeedLimit(350.0, 350.0)
