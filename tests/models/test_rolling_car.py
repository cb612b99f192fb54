"""A rolling car in a steady turn, against geometry; and what its state does in a sample."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.models.rolling_car import RollingCar
from tierod.vehicles import load

CAR = load("rav4").parameters_for(RollingCar.Parameters)
TRUE = {"yaw_rate_offset": 0.0, "steering_wheel_angle_offset": 0.0, "wheel_speed_difference": 0.0}


def at(**given):
    return RollingCar.State(**{**dict.fromkeys(RollingCar.State._fields, 0.0), **given})


def fault_free(**changes):
    return replace(CAR, **{**TRUE, **changes})


def test_on_a_circle_every_wheel_rolls_as_fast_as_its_own_circle_is_long():
    speed, radius = 6.0, 12.0
    car = fault_free()
    seen = RollingCar.output(at(speed=speed, yaw_rate=speed / radius), (), car)
    half = 0.5 * car.track_width
    assert seen.wheel_speed_rear_left == pytest.approx(speed * (radius - half) / radius)
    assert seen.wheel_speed_rear_right == pytest.approx(speed * (radius + half) / radius)
    assert seen.lateral_acceleration == pytest.approx(speed**2 / radius)
    assert seen.longitudinal_acceleration == pytest.approx(-car.rear_distance * (speed / radius) ** 2)


def test_the_wheel_is_turned_by_geometry_at_a_crawl_and_by_understeer_on_top_when_it_is_fast():
    car = fault_free()
    base = car.front_distance + car.rear_distance
    slow = RollingCar.output(at(speed=1.5, yaw_rate=1.5 / 10.0), (), car)
    assert slow.steering_wheel_angle * car.steering_ratio == pytest.approx(np.arctan(base / 10.0), rel=0.01)
    fast = RollingCar.output(at(speed=30.0, yaw_rate=0.1), (), car)
    front = car.mass * car.rear_distance / base * 3.0 / car.front_cornering_stiffness
    rear = car.mass * car.front_distance / base * 3.0 / car.rear_cornering_stiffness
    steer = np.arctan(base * 0.1 / 30.0) + front - rear
    assert fast.steering_wheel_angle * car.steering_ratio == pytest.approx(steer, rel=1e-9)


def test_the_steering_leads_the_yaw_rate():
    car = fault_free(turn_in=0.2)
    turning = RollingCar.output(at(speed=10.0, yaw_acceleration=0.5), (), car).steering_wheel_angle
    steady = RollingCar.output(at(speed=10.0, yaw_rate=0.1), (), car).steering_wheel_angle
    assert turning == pytest.approx(steady)


def test_speed_and_yaw_rate_go_on_and_errors_fade():
    state = at(speed=10.0, acceleration=2.0, yaw_rate=0.1, yaw_acceleration=0.4, bank_acceleration=1.0)
    for _ in range(100):
        state = RollingCar.transition(state, (), CAR)
    assert state.speed == pytest.approx(12.0)
    assert state.bank_acceleration == pytest.approx(np.exp(-1.0 / CAR.wander.road))
    # The integral of an acceleration that fades with its time constant.
    fade = CAR.wander.turning
    assert state.yaw_rate == pytest.approx(0.1 + 0.4 * fade * (1.0 - np.exp(-1.0 / fade)), rel=0.02)
