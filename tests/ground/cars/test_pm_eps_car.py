from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ground.channels import Run
from tierod.core.graph.trace import trace
from tierod_lab.ground.cars.car import Start
from tierod_lab.ground.cars.eps_car import EpsCar, PmEpsCar
from tierod_lab.ground.chassis import SingleTrack
from tierod_lab.ground.motor import EPS_MOTOR, Warming
from tierod_lab.ground.recorder import channel_names

CAR = PmEpsCar(chassis=SingleTrack(), start=Start(12.0))
COUNT = 4000
INPUTS = {"demand__speed": 12.0, "demand__steering_wheel_angle": 1.2 * np.sin(3.0 * np.arange(COUNT) * 1e-3)}


@cache
def swinging(**inputs):
    return Run(CAR, COUNT, **INPUTS, **inputs)


def gain(run):
    asked = run["motor_target_torque"]
    return run["motor_torque"] @ asked / (asked @ asked)


def test_every_channel_has_one_name():
    assert sum(len(columns) for columns in channel_names(CAR).values()) == len(trace(CAR).output)


def test_it_steers_as_the_car_with_a_lag_for_a_motor():
    plain = Run(EpsCar(chassis=SingleTrack(), start=Start(12.0)), COUNT, **INPUTS)
    for name in ("steering_wheel_angle", "yaw_rate", "motor_torque"):
        error = swinging()[name] - plain[name]
        assert np.sqrt(np.mean(error**2)) < 0.05 * np.std(plain[name]), name


def test_currents_make_the_torque():
    run = swinging()
    current = np.hypot(run["motor_current_alpha"], run["motor_current_beta"])[::10]
    constant = 1.5 * 4 * run["truth_motor_flux"]
    error = constant * current - np.abs(run["motor_torque"])
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.max(np.abs(run["motor_torque"]))


def test_magnets_that_are_hot_give_less():
    motor = replace(EPS_MOTOR, warming=Warming(ambient_temperature=393.15))
    hot = Run(replace(CAR, motor=motor), COUNT, **INPUTS)
    weakened = hot["truth_motor_flux"][0] / EPS_MOTOR.control.flux
    assert weakened < 0.9
    assert gain(hot) == pytest.approx(weakened, rel=0.03)
    assert hot["truth_motor_resistance"][0] > 1.3 * swinging()["truth_motor_resistance"][0]


def test_a_false_rotor_angle_costs_torque():
    run = swinging(ports__motor_angle_mechanical__offset=np.radians(60.0) / 4.0)
    assert gain(run) == pytest.approx(0.5, abs=0.05)


def test_a_dead_motor_leaves_the_hands_alone():
    run = swinging(ports__motor_torque__gain=0.0)
    assert np.max(np.abs(run["motor_torque"])) < 0.01 * np.max(np.abs(run["motor_target_torque"]))
    assert np.max(np.abs(run["driver_torque"])) > 1.5 * np.max(np.abs(swinging()["driver_torque"]))


def test_a_weak_motor_has_weak_currents():
    run = swinging(ports__motor_torque__gain=0.5)
    assert gain(run) == pytest.approx(0.5 * gain(swinging()), rel=0.02)
    current = np.hypot(run["motor_current_alpha"], run["motor_current_beta"])[::10]
    error = 6.0 * run["truth_motor_flux"] * current - np.abs(run["motor_torque"])
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.max(np.abs(run["motor_torque"]))
