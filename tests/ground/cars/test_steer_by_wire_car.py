from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ground.channels import Run
from tierod.core.graph.trace import trace
from tierod.physics import single_track
from tierod_lab.ground.cars.car import Start
from tierod_lab.ground.cars.steer_by_wire_car import SteerByWireCar
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.control.angle_control import Feel
from tierod_lab.ground.control.driver import HumanDriver
from tierod_lab.ground.recorder import channel_names

CAR = SteerByWireCar(chassis=SingleTrack(), driver=HumanDriver(persistence=0.0), start=Start(15.0))
COUNT = 4000
SWING = 0.8 * np.sin(3.0 * np.arange(COUNT) * 1e-3)


@cache
def swinging(**inputs):
    return Run(CAR, COUNT, demand__speed=15.0, demand__steering_wheel_angle=SWING, **inputs)


def test_every_channel_has_one_name():
    assert len(channel_names(CAR)) == len(trace(CAR).output)


def test_road_wheels_step_as_asked():
    """Of 2 degrees by a false sensor of the steering wheel, which no hands turn."""
    car, offset = replace(CAR, feel=Feel(0.0, 0.0, 0.0)), np.radians(2.0) * 17.0
    run = Run(car, 3000, demand__speed=15.0, ports__steering_wheel_angle__offset=offset)
    angle = np.degrees(run["road_wheel_angle"])
    assert angle[-1] == pytest.approx(2.0, abs=0.02)
    assert np.max(angle) < 2.4
    assert 0.01 < np.argmax(angle > 1.8) * 1e-3 < 0.15
    assert np.all(np.abs(angle[600:] - 2.0) < 0.1)


def test_equation_1_holds_along_a_drive():
    """J_w 3.5 kg m2 and b_w 160 Nms/rad with the true friction and kingpins; Ackermann off."""
    linkage = replace(CAR.steering.linkage, ackermann_gain=0.0)
    car = replace(CAR, steering=replace(CAR.steering, linkage=linkage))
    run = Run(car, COUNT, demand__speed=15.0, demand__steering_wheel_angle=SWING)
    left = 3.5 * run["truth_road_wheel_acceleration"] + 160.0 * run["road_wheel_rate"]
    left += run["truth_road_wheel_friction"] + run["truth_kingpin_torque"]
    driving = 17.0 * 3.0 * 75.0 * 0.7 * 0.06 * run["motor_current"]
    np.testing.assert_allclose(left, driving, atol=1e-3 * np.max(np.abs(driving)))
    assert np.max(np.abs(driving)) > 100.0


def test_steady_yaw_gain_is_the_closed_form():
    run = Run(CAR, 6000, demand__speed=15.0, demand__steering_wheel_angle=0.2)
    gain = single_track.steady_yaw_gain(run["truth_speed"][-1], CAR.chassis.wheelbase, CAR.chassis.understeer_gradient)
    assert run["yaw_rate"][-1] / run["road_wheel_angle"][-1] == pytest.approx(gain, rel=0.01)


def test_hands_feel_the_spring_and_the_load():
    run = swinging()
    assert np.corrcoef(run["driver_torque"], run["steering_wheel_angle"])[0, 1] > 0.8
    light = Run(
        replace(CAR, feel=replace(CAR.feel, load_share=0.0)),
        COUNT,
        demand__speed=15.0,
        demand__steering_wheel_angle=SWING,
    )
    assert np.std(light["driver_torque"]) < 0.8 * np.std(run["driver_torque"])


def test_no_torque_no_steering_and_half_of_it_is_made_up_for():
    dead, weak, fault_free = (
        swinging(ports__motor_torque__gain=0.0),
        swinging(ports__motor_torque__gain=0.5),
        swinging(),
    )
    assert np.max(np.abs(dead["road_wheel_angle"])) < 1e-6
    assert np.std(weak["motor_target_torque"]) > 1.5 * np.std(fault_free["motor_target_torque"])
    assert np.degrees(np.std(weak["road_wheel_angle"] - fault_free["road_wheel_angle"])) < 0.3


def test_a_false_road_wheel_angle_is_steered_away():
    run, fault_free = swinging(ports__road_wheel_angle__offset=0.01), swinging()
    away = run["road_wheel_angle"][1000:] - fault_free["road_wheel_angle"][1000:]
    assert np.mean(away) == pytest.approx(-0.01, abs=5e-4)


def test_standing_it_turns_against_the_ground():
    run = Run(replace(CAR, start=Start(0.0)), COUNT, demand__steering_wheel_angle=4.0 * SWING)
    assert np.max(np.abs(run["motor_torque"])) < CAR.steering.motor.maximum_torque
    error = run["road_wheel_angle"] - run["target_road_wheel_angle"]
    assert np.degrees(np.sqrt(np.mean(error**2))) < 0.5
