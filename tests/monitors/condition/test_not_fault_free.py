"""Sensors that no declaration accuses, and that are not fault-free either."""

import math

import numpy as np
import pytest

from monitors.condition.motion_alone import drive
from monitors.condition.small_car import STEP, SmallCar, recordings, vehicle_of
from said import said
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import LOSS, STUCK, Injected

SEED = 91
"""Its yaw rate stays below 0.01 rad/s from 15 to 25 s."""


@pytest.fixture(scope="module")
def straight():
    made = drive(SEED).slice(0.0, 40.0)
    return Recording(dict(made.channels))


def test_a_yaw_rate_that_is_lost_on_a_straight_road_is_not_called_fault_free(straight):
    fault = Injected("yaw_rate", LOSS, math.nan, 15.0, 25.0).fault
    found = diagnose(injected(straight, [fault]), load("rav4"), "condition")
    (yaw,) = (each for each in found.elements if each.name == "yaw_rate")
    assert yaw.status is Status.NOT_TESTABLE
    assert "stayed the same from 15.0" in yaw.cause
    finding = found.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "yaw rate: its reading stayed the same from 15.0" in finding.cause


@pytest.fixture(scope="module")
def bends():
    return Recording(dict(drive(11, 60.0).channels))


@pytest.mark.parametrize("sensor", ["yaw_rate", "steering_wheel_angle"])
def test_a_signal_without_values_for_some_seconds_is_named_with_its_times(bends, sensor):
    read = bends[sensor]
    values = np.where((read.time >= 25.0) & (read.time < 30.0), math.nan, read.values)
    found = diagnose(bends.with_channels([Channel(sensor, read.time, values, read.unit)]), load("rav4"), "condition")
    (lost,) = (each for each in found.elements if each.name == sensor)
    assert lost.status is Status.NOT_TESTABLE
    assert lost.cause.startswith("no reading from 25.0")
    assert found.status.exit_code == 2
    assert "5 of 12 are fault-free" in said(found.findings[0])


@pytest.mark.parametrize("sensor", ["yaw_rate", "wheel_speed_front_right"])
@pytest.mark.parametrize("start", [12.0, 20.0, 28.0, 36.0, 44.0])
def test_a_sensor_with_noise_that_is_stuck_for_three_seconds_is_never_fault_free(bends, sensor, start):
    fault = Injected(sensor, STUCK, math.nan, start, start + 3.0).fault
    found = diagnose(injected(bends, [fault]), load("rav4"), "condition")
    (stuck,) = (each for each in found.elements if each.name == sensor)
    assert stuck.status is Status.FAULT or f"stayed the same from {start - 0.01:.2f} s" in stuck.cause
    assert found.status.exit_code in (1, 2)


def test_a_fault_free_drive_with_bends_is_healthy(bends):
    assert diagnose(bends, load("rav4"), "condition").findings[0].status is Status.HEALTHY


def test_a_fault_free_straight_road_is_healthy(straight):
    assert diagnose(straight, load("rav4"), "condition").findings[0].status is Status.HEALTHY


def test_a_steering_angle_that_related_signals_call_stuck_is_neither_fault_free_nor_a_fault_of_the_yaw_rate():
    """A steering angle that rests in a slalom, whose yaw rate then looks wrong to the filters."""
    car = SmallCar(1100.0, 1600.0, 0.95, 1.5, 1.45, 40e3, 0.95, zero=0.01)
    time = np.arange(0.0, 60.0, STEP)
    (read,) = recordings([(car, (np.full(len(time), 12.0), 0.03 * np.sin(0.6 * time)))], 5)
    yaw, speed = read["yaw_rate"], read["vehicle_speed"]
    across = Channel("lateral_acceleration", yaw.time, np.round(yaw.values * speed.values / 0.03) * 0.03, "m/s**2")
    held = Injected("steering_wheel_angle", STUCK, math.nan, 42.0, 52.0).fault
    found = diagnose(injected(read.with_channels([across]), [held]), vehicle_of(car, "small"), "condition")
    states = {each.name: each for each in found.elements}
    cause = "its reading stayed the same from 42.00 s to 52.00 s while related signals moved"
    assert states["steering_wheel_angle"].status is Status.NOT_TESTABLE
    assert states["steering_wheel_angle"].cause.startswith(cause)
    assert states["yaw_rate"].status is Status.NOT_TESTABLE
    assert states["yaw_rate"].cause.startswith("a sensor that stood still contradicted it from 42.00 s to 53.00 s")
    assert f"steering wheel angle: {cause}" in found.findings[0].cause
    assert "bus" not in found.findings[0].action
