"""Models of the vehicle: single track, lateral motion, rolling and automated car."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.block import skeleton
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.lateral_motion import (
    AxleLoad,
    Driven,
    DrivenByWire,
    LateralParameters,
    Sampled,
    axle_force,
    lateral_motion,
)
from tierod.models.single_track import RollingCar
from tierod.physics.motion import GRAVITY, steady_yaw_gain, understeer_gradient
from tierod.vehicles import load

LATERAL = LateralParameters(1640.0, 3500.0, 1.33, 1.31, 100e3, 140e3, pneumatic_trail=0.0)


def driven(model, car, inputs, seconds, step=0.01, start=None, count=0):
    p = Sampled(car, step, (0.0,) * count, (1.0,) * count)
    x = model.State(*(0.0 for _ in model.State._fields)) if start is None else start
    for _ in range(round(seconds / step)):
        x = model.transition(x, inputs, p)
    return x, model.output(x, inputs, p)


@pytest.mark.parametrize(
    ("step", "speed"),
    [(0.01, 5.0), (0.01, 25.0), (0.01, 40.0), (0.001, 40.0)]
    + [pytest.param(0.001, speed, marks=pytest.mark.slow) for speed in (5.0, 25.0)],
)
def test_it_turns_steadily_as_the_single_track(speed, step):
    steer = 0.002
    x, y = driven(lateral_motion(), LATERAL, Driven(speed, 0.0, steer), 6.0, step)
    gradient = understeer_gradient(LATERAL.mass, 1.33, 1.31, 100e3, 140e3)
    yaw_rate = speed * steer / (2.64 + gradient * speed * speed)
    assert y.yaw_rate == pytest.approx(yaw_rate, rel=2e-3)
    rear_slip = LATERAL.mass * speed * yaw_rate * 1.33 / 2.64 / 140e3
    assert x.lateral_speed == pytest.approx(1.31 * yaw_rate - speed * rear_slip, rel=5e-3, abs=1e-5)
    assert y.lateral_acceleration == pytest.approx(speed * yaw_rate * (1.0 + LATERAL.roll_share), rel=2e-3)


@pytest.mark.parametrize(
    ("step", "roll"),
    [(0.01, False), (0.01, True), (0.001, True), pytest.param(0.001, False, marks=pytest.mark.slow)],
)
def test_it_comes_to_the_motion_of_rolling_wheels_at_walking_pace(step, roll):
    x, y = driven(lateral_motion(roll=roll), LATERAL, Driven(0.6, 0.0, 0.4), 8.0, step)
    assert y.yaw_rate == pytest.approx(0.6 * math.tan(0.4) / 2.64, rel=0.02)
    assert x.lateral_speed == pytest.approx(1.31 * y.yaw_rate, rel=0.02)


def test_a_banked_road_is_felt_by_the_motion_and_not_by_the_sensor():
    model = lateral_motion(("bank_angle",))
    p = Sampled(LATERAL, 0.01, (0.0,), (1.0,))
    x = model.State(0.0, 0.0, 0.0, 0.0, 0.05)
    after = model.transition(x, Driven(25.0, 0.0, 0.0), p)
    assert after.lateral_speed == pytest.approx(-0.01 * GRAVITY * math.sin(0.05))
    assert model.output(x, Driven(25.0, 0.0, 0.0), p).lateral_acceleration == 0.0


@pytest.mark.parametrize("step", [0.001, 0.01])
def test_by_wire_sliding_friction_has_its_level_and_adds_no_damping(step):
    model, car = lateral_motion(steering=True), replace(LATERAL, mechanical_trail=0.0)
    rate = -0.3
    torque = -car.road_wheel_friction + car.road_wheel_damping * rate
    x, _ = driven(model, car, DrivenByWire(10.0, 0.0, torque, 1.0), 0.3, step)
    assert x.friction_share == -1.0
    assert x.road_wheel_rate == pytest.approx(rate, rel=1e-4)


STIFFNESS, FRICTION, SHAPE, LOAD = 100e3, 0.9, 1.5, 8000.0


def force(slip, longitudinal=0.0, vertical=LOAD, friction=FRICTION, growth=0.6):
    return axle_force(slip, STIFFNESS, friction, SHAPE, AxleLoad(vertical, LOAD, longitudinal), growth)


ROLLING = load("rav4").parameters_for(RollingCar.Parameters)
TRUE = {"yaw_rate_offset": 0.0, "steering_wheel_angle_offset": 0.0, "wheel_speed_difference": 0.0}


def at(**given):
    return RollingCar.State(**{**dict.fromkeys(RollingCar.State._fields, 0.0), **given})


def fault_free(**changes):
    return replace(ROLLING, **{**TRUE, **changes})


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


AUTOMATED = load("smartload").parameters_for(AutomatedVehicle.Parameters)
PLAIN = replace(AUTOMATED, turn_slip_stiffness=0.0, jacking_torque=0.0, rolling_resistance=0.0, drag=0.0)
REST = skeleton(AutomatedVehicle.State)
NOTHING = skeleton(AutomatedVehicle.Input)


def held(state, inputs, car, steps, **fixed):
    for _ in range(steps):
        state = AutomatedVehicle.transition(state, inputs, car)._replace(**fixed)
    return state


@pytest.mark.parametrize("speed", [2.0, 6.0, 12.0])
def test_a_gentle_steady_turn_is_that_of_the_single_track(speed):
    car = replace(PLAIN, tyre_friction=50.0)
    wheels = 0.01
    still = {"speed": speed, "column_angle": wheels / car.steering_ratio, "column_rate": 0.0}
    state = held(REST._replace(**still), NOTHING, car, 2000, **still)
    front, rear = car.front_distance - car.pneumatic_trail, car.rear_distance + car.pneumatic_trail
    gradient = understeer_gradient(car.mass, front, rear, car.front_cornering_stiffness, car.rear_cornering_stiffness)
    expected = steady_yaw_gain(speed, front + rear, gradient) * wheels
    assert state.yaw_rate == pytest.approx(expected, rel=2e-3)
    output = AutomatedVehicle.output(state, NOTHING, replace(car, roll_share=0.0))
    assert output.lateral_acceleration == pytest.approx(speed * state.yaw_rate, rel=2e-3)
    turned = car.track_width * state.yaw_rate
    assert output.wheel_speed_rear_right - output.wheel_speed_rear_left == pytest.approx(turned, rel=1e-9)
    force = car.rear_distance / (car.front_distance + car.rear_distance) * car.mass * speed * state.yaw_rate
    rod = car.steering_ratio / car.rack_ratio * (car.mechanical_trail + car.pneumatic_trail) * force
    assert output.tie_rod_force == pytest.approx(rod, rel=0.03)


def test_more_drive_on_the_right_turns_to_the_left():
    inputs = NOTHING._replace(drive_right=50.0, drive_right_now=50.0)
    state = AutomatedVehicle.transition(REST._replace(speed=5.0), inputs, PLAIN)
    moment = 0.5 * PLAIN.track_width * 50.0 / PLAIN.wheel_radius
    assert state.yaw_rate == pytest.approx(PLAIN.sample_time * moment / PLAIN.yaw_inertia, rel=1e-3)
