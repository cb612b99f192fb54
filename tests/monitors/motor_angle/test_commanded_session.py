"""Recordings that hold the inverter's command and no measured voltage."""

from dataclasses import replace

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle.monitored import vehicle_with
from said import said
from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.core.statuses import Status
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.clarke_park import StatorVector, inverse_clarke
from tierod.vehicles import load
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import to_and_fro

DRIVE = to_and_fro(82, 9.0, inverter=Inverter(dead_time=1e-6, forward_drop=0.7, knee_current=1.0))
TARGETS = ("motor_target_voltage_alpha", "motor_target_voltage_beta")
DUTIES = ("motor_duty_cycle_a", "motor_duty_cycle_b", "motor_duty_cycle_c")


def recorded(samples, *more, without=("motor_voltage_alpha", "motor_voltage_beta")):
    named = dict(zip(MotorAngleObserver.Sample._fields, samples.T, strict=True)) | dict(more)
    there = {name: np.isfinite(values) for name, values in named.items() if name not in without}
    return Recording(
        {
            name: Channel(name, DRIVE.time[known], named[name][known], SIGNALS[name].unit)
            for name, known in there.items()
        }
    )


COMMANDS = tuple(zip(TARGETS, DRIVE.commands.T, strict=True))
PHASES = inverse_clarke(StatorVector(*DRIVE.commands.T))
DUTY_CYCLES = (
    *zip(DUTIES, (0.5 + phase / 13.0 for phase in PHASES), strict=True),
    ("supply_voltage", np.where(np.arange(len(DRIVE.angle)) % 1000 == 0, 13.0, np.nan)),
)
"""The supply comes every 0.1 s."""


def finding(recording, vehicle="motor-bench"):
    return diagnose(recording, vehicle, "motor-angle").findings[0]


@pytest.mark.parametrize(
    ("more", "variant", "result"),
    [
        (COMMANDS, "commanded-voltage", "the commanded ones, less the estimated voltage loss"),
        (DUTY_CYCLES, "duty-cycles", "duty cycles times the supply"),
    ],
)
def test_it_says_which_voltages_it_rests_on_and_what_the_inverter_takes(more, variant, result):
    found = finding(recorded(DRIVE.samples, *more))
    assert found.monitor == f"motor-angle, {variant}"
    assert found.status is Status.HEALTHY
    assert "commanded voltages give" in said(found)
    assert result in found.warnings[0]
    assert found.evidence["inverter_voltage_loss_v"] == pytest.approx(0.83, abs=0.06)
    assert len(found.warnings) == 1


@pytest.mark.parametrize("knee", [0.4, 2.5])
def test_a_wrong_knee_is_said_and_the_sensor_still_judged(knee):
    found = finding(recorded(DRIVE.samples, *COMMANDS), vehicle_with(inverter_knee_current=knee))
    assert found.status is Status.HEALTHY
    assert f"not at {knee:g} A as in the vehicle file" in found.warnings[1]
    assert found.evidence["inverter_knee_current_a"] == pytest.approx(1.0, rel=0.15)


def test_currents_of_the_wrong_sign_are_named_on_commands_too():
    samples = DRIVE.samples * np.array([-1.0, -1.0, 1.0, 1.0, 1.0])
    found = finding(recorded(samples, *COMMANDS))
    assert found.status is Status.NOT_TESTABLE
    assert "the currents have the wrong sign" in found.cause


def test_what_could_be_recorded_in_place_of_voltages_is_reported():
    with pytest.raises(InputError, match="'commanded-voltage' takes motor_target_voltage_alpha, motor_target"):
        finding(recorded(DRIVE.samples))


def test_a_vehicle_without_its_inverter_is_refused_by_name():
    vehicle = load("motor-bench")
    bare = replace(vehicle, parameters={k: v for k, v in vehicle.parameters.items() if not k.startswith("inverter")})
    with pytest.raises(ParameterError, match="inverter_voltage_loss"):
        finding(recorded(DRIVE.samples, *COMMANDS), bare)
