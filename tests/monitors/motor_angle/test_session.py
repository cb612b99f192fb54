"""Recordings that hold the inverter's command and no measured voltage."""

import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding, recording, vehicle_with
from said import estimated, said
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.motor import StatorVector, inverse_clarke
from tierod_lab.ground.motor import Inverter
from tierod_lab.papers.motor_angle.bench import FAULTS, FIVE_DEGREES, RATE, drive, offset, to_and_fro

ANGLE = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]]
LATE = np.arange(len(ANGLE)) >= 62_000


def diagnosed(samples, **more):
    return diagnose(recording(samples), "motor-bench", "motor-angle", **more)


def test_an_electrical_angle_given_as_mechanical_is_named():
    found = finding(changed(motor_angle_mechanical=4.0 * ANGLE))
    assert found.status is Status.NOT_TESTABLE
    assert "electrical, but named as mechanical" in found.cause


@pytest.mark.parametrize("pairs", [3.0, 5.0])
def test_a_wrong_pole_pair_number_is_named(pairs):
    found = finding(FAULT_FREE().samples, vehicle_with(motor_pole_pairs=pairs))
    assert found.status is Status.NOT_TESTABLE
    assert "as with 4 pole pairs" in found.cause


def test_a_low_supply_is_the_root_of_what_it_does_and_fills_one_code_of_the_memory(tmp_path):
    path, supply = tmp_path / "memory.json", np.where(LATE, 7.0, 13.0)
    found = finding(changed(supply_voltage=supply, motor_angle_mechanical=ANGLE + FIVE_DEGREES * LATE), memory=path)
    assert found.cause == "the supply of the controller is too low"
    assert "angle_alarm_from_s" in found.evidence
    memory = FaultMemory.opened(path, "motor-bench")
    raised = [name for name, entry in memory.entries.items() if entry.status & 0x08]
    assert raised == ["motor-supply-low"]


@pytest.mark.parametrize(
    ("name", "cause", "code"),
    [
        ("stuck", "stands still", "motor-angle-stuck"),
        ("current phases b and c swapped", "contradict the model of the motor", "motor-currents"),
    ],
)
@pytest.mark.parametrize("begin", [3.0, 6.2])
def test_a_stalled_drive_has_the_right_root(tmp_path, name, cause, code, begin):
    fault = next(fault for fault in FAULTS if fault.name == name)
    diagnosis = diagnosed(drive(3, 8.0, fault, begin).samples, memory=tmp_path / "memory.json")
    assert cause in diagnosis.findings[0].cause
    memory = FaultMemory.opened(tmp_path / "memory.json", "motor-bench")
    raised = {each for each, entry in memory.entries.items() if entry.status & 0x08}
    assert code in raised
    assert not raised & ({"motor-angle-stuck", "motor-currents"} - {code})


def test_a_zero_that_leaps_beside_a_slow_motor_accuses_no_currents(tmp_path):
    """Its increments disturb the observer, while sine and cosine show at once whose fault it is."""
    slow = 50_000 + int(np.argmin(np.abs(drive(3, 8.0).speed[50_000:70_000])))
    leap = offset(12.0)
    samples = drive(3, 8.0, leap, slow / RATE).samples.copy()
    late = np.arange(len(samples)) >= slow
    true = 4.0 * (samples[:, COLUMN["motor_angle_mechanical"]] - np.where(late, leap.offset(np.zeros(1)), 0.0))
    jumped = finding(samples)
    assert math.degrees(jumped.estimate.value) == pytest.approx(12.0, abs=0.1)
    assert f"by a step of {estimated(jumped)} electrical" in said(jumped)
    assert jumped.since == pytest.approx(slow / RATE, abs=0.1)
    samples[:, COLUMN["resolver_sine"]], samples[:, COLUMN["resolver_cosine"]] = np.sin(true), np.cos(true)
    diagnosis = diagnosed(samples, memory=tmp_path / "memory.json")
    assert "sine and cosine" in diagnosis.findings[0].cause
    assert "model_alarm_from_s" in diagnosis.findings[0].evidence
    raised = FaultMemory.opened(tmp_path / "memory.json", "motor-bench").entries
    assert "motor-angle-mismatch" in {name for name, entry in raised.items() if entry.status & 0x08}
    assert not raised.get("motor-currents") or not raised["motor-currents"].status & 0x08


def with_phases(samples, names="abc"):
    """A recording of phase currents in place of their vector."""
    channels = dict(recording(samples).channels)
    alpha, beta = channels.pop("motor_current_alpha"), channels.pop("motor_current_beta")
    across = 0.5 * math.sqrt(3.0) * beta.values
    values = {"a": alpha.values, "b": across - 0.5 * alpha.values, "c": -across - 0.5 * alpha.values}
    for name in names:
        channels[f"motor_current_{name}"] = Channel(f"motor_current_{name}", alpha.time, values[name], "A")
    return channels


@pytest.mark.parametrize("names", ["abc", "ab"])
def test_two_or_three_phase_currents_are_as_good_as_their_vector(names):
    found = finding(Recording(with_phases(FAULT_FREE().samples, names)), spread=False)
    assert found.status is Status.HEALTHY
    assert found.evidence == pytest.approx(finding(FAULT_FREE().samples).evidence, rel=1e-6)


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
