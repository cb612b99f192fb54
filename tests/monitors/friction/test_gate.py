from __future__ import annotations

import math

import pytest

from tierod.monitors.friction.signals import FrictionGate

OPEN = {"driver_torque": 1.0, "motor_torque": 0.1, "steering_wheel_rate": 0.3}


def test_opens_while_driver_and_motor_work_alike():
    assert FrictionGate().opened(**OPEN) == 1.0
    assert FrictionGate().opened(**{name: -value for name, value in OPEN.items()}) == 1.0


@pytest.mark.parametrize(
    "change",
    [
        {"driver_torque": 0.5},
        {"motor_torque": -0.1},
        {"motor_torque": 0.0},
        {"steering_wheel_rate": 0.05},
        {"steering_wheel_rate": -1.0},
        {"driver_torque": math.nan},
        {"motor_torque": math.nan},
        {"steering_wheel_rate": math.nan},
    ],
)
def test_each_condition_of_equation_14_closes_it(change):
    assert FrictionGate().opened(**(OPEN | change)) == 0.0


@pytest.mark.parametrize(("speed", "opened"), [(3.5, 1.0), (3.0, 0.0), (math.nan, 0.0)])
def test_minimum_speed_is_an_option(speed, opened):
    assert FrictionGate(minimum_speed=3.0).opened(**OPEN, vehicle_speed=speed) == opened
    assert FrictionGate().opened(**OPEN, vehicle_speed=speed) == 1.0
