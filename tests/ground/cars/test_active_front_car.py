from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ground.channels import Run
from tierod.core.block import leaves, rebuild, skeleton
from tierod.core.graph.trace import trace
from tierod_lab.ground.cars.active_front_car import ActiveFrontCar
from tierod_lab.ground.cars.car import Start
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.control.driver import HumanDriver
from tierod_lab.ground.recorder import channel_names

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

CAR = ActiveFrontCar(chassis=SingleTrack(), driver=HumanDriver(persistence=0.0), start=Start(15.0))
COUNT = 3000
TIME = np.arange(COUNT) * 1e-3
SWING = 0.6 * np.sin(4.0 * TIME)


@cache
def swinging(**inputs):
    return Run(CAR, COUNT, demand__speed=15.0, demand__steering_wheel_angle=SWING, **inputs)


def motor_angle(run):
    return run["motor_angle_mechanical"][::10]


def test_every_channel_has_one_name_and_the_motor_ten_samples_a_step():
    names = channel_names(CAR)
    assert sum(len(columns) for columns in names.values()) == len(trace(CAR).output)
    fine = {name for name, columns in names.items() if len(columns) == 10}
    assert {"motor_current_alpha", "motor_voltage_beta", "motor_angle_mechanical", "motor_speed"} <= fine
    assert {len(columns) for columns in names.values()} == {1, 10}


def test_angles_superpose():
    run, steering = swinging(), CAR.steering
    shaft = run["truth_gear_input_angle"] / steering.input_ratio
    np.testing.assert_allclose(run["pinion_angle"], motor_angle(run) / steering.motor_ratio + shaft, atol=1e-9)
    twist = run["steering_wheel_angle"] - run["truth_gear_input_angle"]
    assert 0.005 < np.max(np.abs(twist)) < 0.1


@pytest.mark.parametrize("speed", [3.0, 30.0])
def test_the_ratio_follows_the_speed(speed):
    car = replace(CAR, start=Start(speed))
    run = Run(car, 2000, demand__speed=speed, demand__steering_wheel_angle=0.2)
    gain = run["pinion_angle"][-1] / run["truth_gear_input_angle"][-1]
    assert gain == pytest.approx(CAR.ratio.gain(speed), rel=0.03)
    assert np.sign(motor_angle(run)[-1]) == np.sign(gain - 1.0)


def test_the_motor_follows_its_target_within_a_quarter_of_a_degree_of_the_pinion():
    run = swinging()
    error = (motor_angle(run) - run["target_motor_angle_mechanical"]) / CAR.steering.motor_ratio
    assert np.degrees(np.sqrt(np.mean(error**2))) < 0.25
    assert np.max(np.abs(motor_angle(run))) > 1.0


def test_locked_the_wheel_steers_by_itself():
    run = swinging(ports__motor_lock__offset=1.0)
    assert not np.any(motor_angle(run))
    np.testing.assert_allclose(run["pinion_angle"], run["truth_gear_input_angle"], atol=1e-12)
    assert np.max(np.abs(run["yaw_rate"])) > 0.1


def test_the_motor_alone_turns_the_pinion_against_held_hands():
    run = Run(CAR, 2000, demand__speed=15.0, ports__steering_wheel_angle__offset=0.5)
    superposed = motor_angle(run)[-1] / CAR.steering.motor_ratio
    target = 0.5 * (CAR.ratio.gain(15.0) - 1.0)
    assert superposed == pytest.approx(target, rel=0.3)
    assert run["pinion_angle"][-1] > 0.5 * superposed
    assert run["driver_torque"][-1] > 0.2


def test_a_false_motor_angle_is_turned_away_and_the_identity_shows():
    run, fault_free = swinging(ports__motor_angle_mechanical__offset=0.05), swinging()
    away = motor_angle(run)[-500:] - motor_angle(fault_free)[-500:]
    np.testing.assert_allclose(away, -0.05, atol=0.02)


def test_a_weak_motor_asks_for_more():
    run, fault_free = swinging(ports__motor_torque__gain=0.5), swinging()
    more = np.std(run["motor_target_torque"][1000:]) / np.std(fault_free["motor_target_torque"][1000:])
    assert more == pytest.approx(2.0, rel=0.2)
    np.testing.assert_allclose(motor_angle(run)[1000:], motor_angle(fault_free)[1000:], atol=0.25)


def test_assist_faults_act_on_the_column():
    run = swinging(ports__column_assist_torque__gain=0.0)
    assert np.max(np.abs(run["column_assist_torque"])) < 1e-9
    assert np.max(np.abs(run["driver_torque"])) > 1.5 * np.max(np.abs(swinging()["driver_torque"]))


def test_a_finer_step_gives_the_same():
    half = replace(
        CAR,
        step_time=5e-4,
        motor=replace(CAR.motor, substeps=5),
        assist=replace(CAR.assist, step_time=5e-4),
        angle_control=replace(CAR.angle_control, step_time=5e-4),
        driver=replace(CAR.driver, step_time=5e-4, delay_steps=300),
    )
    held = np.repeat(SWING[:1500], 2)
    fine = Run(half, 3000, demand__speed=15.0, demand__steering_wheel_angle=held)
    for name in ("pinion_angle", "yaw_rate", "driver_torque"):
        error = fine[name][::2] - swinging()[name][:1500]
        assert np.sqrt(np.mean(error**2)) < 0.02 * np.std(fine[name]), name
    error = fine["motor_angle_mechanical"] - swinging()["motor_angle_mechanical"][:15000]
    assert np.sqrt(np.mean(error**2)) < 0.03 * np.std(fine["motor_angle_mechanical"])


def test_float_steps_agree_with_the_kernel():
    names = [name for name, _ in leaves(skeleton(CAR.Sample))]
    inputs = {"demand.speed": 15.0, "demand.steering_wheel_angle": 0.3}
    run = Run(CAR, 4, **{name.replace(".", "__"): value for name, value in inputs.items()})
    ones = ("road.adhesion_left", "road.adhesion_right", "road.support", "demand.grip")
    values = [inputs.get(name, 1.0 if name in ones or name.endswith(".gain") else 0.0) for name in names]
    sample, state = rebuild(skeleton(CAR.Sample), values), with_rings(CAR.init())
    for expected in run.result.values:
        state, out = CAR.step(state, sample)
        state = with_rings(state)
        np.testing.assert_allclose([value for _, value in leaves(out)], expected, rtol=1e-7, atol=1e-9)


def with_rings(state):
    ring = state.held.driver.offset_ahead
    mind = state.held.driver._replace(offset_ahead=ring._replace(oldest=ring.initial, newest=None))
    return state._replace(held=state.held._replace(driver=mind))
