from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ground.channels import Run
from tierod.core.graph.trace import trace
from tierod_lab.ground.cars.car import Start
from tierod_lab.ground.cars.demonstrator_car import DemonstratorCar
from tierod_lab.ground.chassis import demonstrator
from tierod_lab.ground.control.automated import Split
from tierod_lab.ground.recorder import channel_names

CAR = DemonstratorCar(start=Start(6.0))
COUNT = 8000
TIME = np.arange(COUNT) * 1e-3
AHEAD = CAR.driver.anticipation


def bends(time):
    """Curvature of the road [1/m]: to the left and right, after two seconds."""
    return 0.08 * np.sin(1.2 * np.maximum(time - 1.0, 0.0))


def driven(car=CAR, **inputs):
    return Run(
        car,
        COUNT,
        demand__speed=6.0,
        demand__attention=1.0,
        road__curvature=bends(TIME),
        demand__curvature_ahead=bends(TIME + AHEAD),
        **inputs,
    )


def fault(value, before=1.0):
    return np.where(TIME < 4.0, before, value)


@cache
def winding():
    return driven()


def test_every_channel_has_one_name():
    names = channel_names(CAR)
    assert len(names) == len(trace(CAR).output)
    assert set(names) >= {
        "steering_wheel_angle",
        "steering_shaft_torque",
        "tie_rod_force",
        "wheel_speed_rear_left",
        "wheel_speed_rear_right",
        "yaw_rate",
        "lateral_acceleration",
        "longitudinal_acceleration",
        "target_steering_wheel_angle",
        "target_vehicle_speed",
        "steering_motor_1_target_torque",
        "steering_motor_2_target_torque",
        "target_drive_torque_left",
        "target_drive_torque_right",
    }


def test_its_axles_have_the_stiffness_asked_for():
    chassis = demonstrator()
    assert chassis.front.stiffness(chassis.front_load) == pytest.approx(35e3)
    assert chassis.rear.stiffness(chassis.rear_load) == pytest.approx(35e3)
    assert min(chassis.front.compliance, chassis.rear.compliance) > 0.0


def test_it_follows_the_road_and_keeps_its_speed():
    run = winding()
    assert np.max(np.abs(run["truth_lateral_offset"])) < 0.35
    np.testing.assert_allclose(run["vehicle_speed"], 6.0, atol=0.25)
    angle, target = run["steering_wheel_angle"], run["target_steering_wheel_angle"]
    assert np.max(np.abs(angle)) > 2.0
    assert np.sqrt(np.mean((angle - target) ** 2)) < 0.08
    np.testing.assert_allclose(
        angle / 19.7, 0.5 * (run["road_wheel_angle_left"] + run["road_wheel_angle_right"]), atol=1e-3
    )


def test_the_tie_rods_carry_what_the_shaft_does_not():
    """Quasi-static balance: F = k_R S + d_R S' on the one side, (M - M_FR) / g on the other, and inertia small."""
    run = winding()
    rack = 31227.0 * run["rack_position"] + 22867.0 * run["rack_speed"]
    pushed = (run["steering_shaft_torque"] - run["truth_friction_resistance"]) * 146.12
    inertia = 146.12 * 0.040 * run["truth_steering_wheel_acceleration"]
    left = pushed - inertia - rack - run["tie_rod_force"]
    assert np.sqrt(np.mean(left[500:] ** 2)) < 0.03 * np.std(run["tie_rod_force"])


def test_two_motors_share_the_work():
    run = winding()
    first, second = run["steering_motor_1_target_torque"], run["steering_motor_2_target_torque"]
    np.testing.assert_allclose(first, second, atol=1e-12)
    swinging = driven(replace(CAR, driver=replace(CAR.driver, split=Split(0.5, 0.15, 0.24))))
    total = swinging["steering_motor_1_target_torque"] + swinging["steering_motor_2_target_torque"]
    loaded = np.abs(total) > 0.5
    share = swinging["steering_motor_1_target_torque"][loaded] / total[loaded]
    np.testing.assert_allclose(np.unique(np.round(share, 9)), [0.35, 0.65])
    turns = np.flatnonzero(np.diff(np.sign(share - 0.5)))
    assert np.median(np.diff(turns)) == 120


def test_one_steering_motor_is_enough_and_asks_for_more():
    run, fault_free = driven(ports__steering_motor_1_torque__gain=fault(0.0)), winding()
    assert np.max(np.abs(run["steering_motor_1_torque"][4100:])) < 1e-6
    assert np.max(np.abs(run["truth_lateral_offset"])) < 0.5
    more = np.std(run["steering_motor_2_target_torque"][5000:]) / np.std(
        fault_free["steering_motor_2_target_torque"][5000:]
    )
    assert more > 1.5


def test_without_steering_motors_the_wheel_motors_steer():
    bend = 0.01 * (TIME > 1.0)
    inputs = {
        "demand__speed": 6.0,
        "demand__attention": 1.0,
        "road__curvature": bend,
        "demand__curvature_ahead": bend,
        "ports__steering_motor_1_torque__gain": 0.0,
        "ports__steering_motor_2_torque__gain": 0.0,
    }
    helped = Run(replace(CAR, driver=replace(CAR.driver, drive_steering=100.0)), COUNT, **inputs)
    alone = Run(CAR, COUNT, **inputs)
    assert not np.any(helped["steering_shaft_torque"] - helped["steering_shaft_torque"][0] > 1.0)
    assert helped["truth_heading"][-1] == pytest.approx(0.01 * 6.0 * 7.0, rel=0.15)
    assert abs(alone["truth_heading"][-1]) < 0.2 * helped["truth_heading"][-1]
    difference = helped["drive_torque_right"] - helped["drive_torque_left"]
    assert np.mean(difference[2000:]) > 50.0


@pytest.mark.parametrize(("side", "sign"), [("left", -1.0), ("right", 1.0)])
def test_a_lost_wheel_motor_pulls_at_the_tie_rods_to_one_side(side, sign):
    inputs = {f"ports__drive_torque_{side}__gain": fault(0.0)}
    run = Run(CAR, COUNT, demand__speed=6.0 + 0.4 * np.maximum(TIME - 3.0, 0.0), demand__attention=1.0, **inputs)
    force = np.mean(run["tie_rod_force"][5000:7000])
    assert np.max(np.abs(run[f"drive_torque_{side}"][4300:])) < 1e-9
    assert np.sign(force) == sign
    assert abs(force) > 5.0


def test_a_false_wheel_speed_slows_the_car_down():
    run = driven(ports__wheel_speed_rear_left__offset=fault(1.0, 0.0))
    assert run["vehicle_speed"][-1] == pytest.approx(5.5, abs=0.1)


def test_a_lost_yaw_rate_and_a_false_angle_are_felt_on_the_path():
    angle = driven(ports__steering_wheel_angle__offset=fault(0.5, 0.0))
    fault_free = winding()
    away = np.mean(angle["steering_wheel_angle"][4150:4250] - fault_free["steering_wheel_angle"][4150:4250])
    assert -0.6 < away < -0.2
    yaw = driven(ports__yaw_rate__gain=fault(0.0))
    assert np.max(np.abs(yaw["truth_lateral_offset"] - fault_free["truth_lateral_offset"])) > 0.02
    assert np.max(np.abs(yaw["truth_lateral_offset"])) < 1.0


def test_it_starts_from_rest_and_stops():
    speed = np.clip(1.0 * TIME, 0.0, 3.0) - np.clip(1.0 * (TIME - 4.0), 0.0, 3.0)
    planned = np.where(TIME < 3.0, 1.0, np.where((TIME > 4.0) & (TIME < 7.0), -1.0, 0.0))
    run = Run(replace(CAR, start=Start(0.0)), COUNT, demand__speed=speed, demand__acceleration=planned)
    assert np.max(np.abs(run["truth_speed"] - speed)) < 0.4
    assert abs(run["truth_speed"][-1]) < 0.1
