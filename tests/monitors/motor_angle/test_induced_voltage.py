"""Currents and voltages held against each other, without the angle sensor."""

from __future__ import annotations

import math

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, SOUND, changed, recording
from tierod.core.findings import Status
from tierod.monitors.motor_angle.voltage_balance import FITS, InducedVoltage
from tierod.monitors.run import diagnose
from tierod.papers.motor_angle.fault_drives import RATE
from tierod.vehicles import load

MOTOR = load("motor-bench")


def share(samples, pieces=1):
    induced = InducedVoltage(MOTOR["motor_resistance"], MOTOR["motor_inductance"], MOTOR["motor_flux"], 1.0 / RATE)
    for piece in np.array_split(samples, pieces):
        current = piece[:, COLUMN["motor_current_alpha"]] + 1j * piece[:, COLUMN["motor_current_beta"]]
        voltage = piece[:, COLUMN["motor_voltage_alpha"]] + 1j * piece[:, COLUMN["motor_voltage_beta"]]
        induced.add(current, voltage)
    return induced.share()


def test_those_of_one_motor_fit_however_they_are_cut():
    assert share(SOUND().samples) < 0.5 * FITS
    assert share(SOUND().samples, 37) == pytest.approx(share(SOUND().samples), rel=1e-9)


@pytest.mark.parametrize("name", ["motor_current_alpha", "motor_voltage_beta"])
@pytest.mark.parametrize("factor", [-1.0, 0.5, 2.0])
def test_one_that_is_wrong_does_not(name, factor):
    assert share(changed(**{name: factor * SOUND().samples[:, COLUMN[name]]})) > 2.0 * FITS


def test_a_motor_that_stands_still_says_nothing():
    assert math.isnan(share(SOUND().samples[:100]))


def finding(samples):
    return diagnose(recording(samples), "motor-bench", "motor-angle").findings[0]


def test_a_sensor_of_noise_is_named_and_not_the_currents():
    angle = SOUND().samples[:, COLUMN["motor_angle_mechanical"]]
    noise = np.random.default_rng(1).normal(size=len(angle))
    found = finding(changed(motor_angle_mechanical=angle + np.nanstd(angle) * noise))
    assert found.status is Status.FAULT
    assert found.cause == "the motor's angle contradicts currents and voltages, which fit each other"


@pytest.mark.parametrize("factor", [-1.0, 2.0])
def test_a_target_that_is_wrong_is_named_where_the_sensor_is_confirmed(factor):
    target = SOUND().samples[:, COLUMN["target_motor_angle_mechanical"]]
    found = finding(changed(target_motor_angle_mechanical=factor * target))
    assert "target_motor_angle_mechanical" in found.cause
    assert "confirm the sensor" in found.cause
