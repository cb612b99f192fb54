from functools import cache

import numpy as np
import pytest

from ground.channels import Run
from tierod.core.graph.trace import trace
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.recorder import channel_names

BENCH = MotorBench()
COUNT = 4000
TARGET = 15.0 * np.sin(4.0 * np.arange(COUNT) * 1e-3)
PERIOD, INDUCTANCE = 1e-4, 1e-4


@cache
def swinging(**inputs):
    return Run(BENCH, COUNT, control=1.0, target_motor_angle=TARGET, **inputs)


def test_every_channel_has_one_name():
    assert sum(len(columns) for columns in channel_names(BENCH).values()) == len(trace(BENCH).output)


def test_it_follows_its_target_against_the_spring():
    run = swinging()
    error = run["motor_angle_mechanical"][::10] - TARGET
    assert np.sqrt(np.mean(error**2)) < 0.1
    assert np.max(run["truth_load_torque"]) == pytest.approx(0.6)
    assert np.min(run["truth_load_torque"]) == pytest.approx(-0.6)


def test_the_flux_of_currents_and_voltages_shows_the_angle():
    run = swinging()
    current = run["motor_current_alpha"] + 1j * run["motor_current_beta"]
    voltage = run["motor_voltage_alpha"] + 1j * run["motor_voltage_beta"]
    resistance = np.repeat(run["truth_motor_resistance"], 10)
    middle = 0.5 * (current[1:] + current[:-1])
    flux = run["truth_motor_flux"][0] + np.cumsum(PERIOD * (voltage[1:] - resistance[1:] * middle))
    angle = np.unwrap(np.angle(flux - INDUCTANCE * current[1:])) / 4.0
    np.testing.assert_allclose(angle, run["motor_angle_mechanical"][1:], atol=1e-3)


def test_sine_and_cosine_turn_with_the_electrical_angle():
    run = swinging()
    angle = np.unwrap(np.arctan2(run["resolver_sine"], run["resolver_cosine"])) / 4.0
    np.testing.assert_allclose(angle, run["motor_angle_mechanical"], atol=1e-6)
    np.testing.assert_allclose(np.hypot(run["resolver_sine"], run["resolver_cosine"]), 2.0, rtol=1e-6)


def test_left_alone_it_rests_and_pushed_it_turns():
    still = Run(BENCH, 200)
    assert not np.any(still["motor_speed"])
    pushed = Run(BENCH, 200, load_torque=-0.6)
    assert pushed["motor_speed"][-1] > 1.0
    held = Run(BENCH, 200, load_torque=-0.6, locked=1.0)
    assert not np.any(held["motor_angle_mechanical"])


def test_a_false_sensor_misleads_the_angle_control():
    run = swinging(ports__motor_angle_mechanical__offset=-0.2)
    away = (run["motor_angle_mechanical"] - swinging()["motor_angle_mechanical"])[::10]
    assert np.mean(away[1000:]) == pytest.approx(0.2, abs=0.02)


def test_half_the_torque_is_asked_for_twice():
    run, fault_free = swinging(ports__motor_torque__gain=0.5), swinging()
    assert np.std(run["motor_target_torque"]) == pytest.approx(2.0 * np.std(fault_free["motor_target_torque"]), rel=0.1)


def test_a_current_sensor_that_reads_too_much_takes_torque_away():
    run = Run(BENCH, 200, motor_torque=1.0, locked=1.0, ports__motor_current_beta__gain=2.0)
    assert run["motor_torque"][-1] == pytest.approx(0.5, rel=0.01)
    assert run["motor_current_beta"][-1] == pytest.approx(0.5 / 0.051, rel=0.02)
