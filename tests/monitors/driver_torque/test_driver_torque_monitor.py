"""Recordings of the column bench and of the virtual car, with faults of signs and parameters put into them."""

from dataclasses import replace

import numpy as np
import pytest

import driven
from exact_vehicle import diagnose
from said import said
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.monitors.driver_torque.definition import DRIVER_TORQUE
from tierod.monitors.driver_torque.facts import CASES
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import ColumnBench
from tierod_lab.ground.courses.bench import BenchHands
from tierod_lab.ground.run import run
from tierod_lab.ground.sensors import SensorSet

BENCH = load("column-bench")
JUDGED = (DRIVER_TORQUE.default, "fixed-lag")
"""Variants that further tests hold against the truth of the bench."""
COURSE = BenchHands(time=60.0, shortest=6.0, longest=9.0, seed=11)


@pytest.fixture(scope="module")
def bench():
    return run(ColumnBench(), COURSE, sensors=SensorSet.bench(), seed=3).recording


def judged(recording, vehicle=BENCH, variant=None):
    diagnosis = diagnose(recording, vehicle, "driver-torque", variant)
    return diagnosis.findings[0], diagnosis


def changed(recording, **factors):
    channels = dict(recording.channels)
    for name, factor in factors.items():
        channels[name] = replace(channels[name], values=factor * channels[name].values)
    return Recording(channels, recording.metadata)


def with_parameter(name, factor):
    parameter = replace(BENCH.parameters[name], value=factor * BENCH.parameters[name].value)
    return replace(BENCH, parameters={**BENCH.parameters, name: parameter})


def test_it_estimates_hands_and_torque_of_a_bench(bench):
    finding, diagnosis = judged(bench)
    present, _ = COURSE.held(np.arange(60_000) * 1e-3)
    on = 1e-3 * float(np.sum(present))
    longest = np.max(np.diff(np.minimum(COURSE.switches, 60.0), prepend=0.0)[::2])
    assert finding.status.quiet
    assert finding.evidence["hands_on_s"] == pytest.approx(on, abs=4.0)
    assert finding.evidence["longest_hands_off_s"] == pytest.approx(longest, abs=1.5)
    assert finding.evidence["error_against_truth_rms_Nm"] < 0.06
    assert "hands on the wheel" in said(finding)
    assert {"hand_torque", "hand_torque_standard_deviation", "hands_on", "true_hand_torque"} <= set(diagnosis.traces)


@pytest.mark.parametrize("variant", [name for name in DRIVER_TORQUE.variants if name not in JUDGED])
def test_every_variant_judges_the_bench(bench, variant):
    finding, diagnosis = judged(bench, variant=variant)
    assert finding.status.quiet
    assert {"hand_torque", "hands_on", "true_hand_torque"} <= set(diagnosis.traces)
    assert finding.evidence["error_against_truth_rms_Nm"] < 0.2
    assert finding.estimate is None or finding.estimate.standard_deviation > 0.0


@pytest.mark.parametrize("name", ["steering_wheel_angle", "driver_torque", "motor_angle_mechanical"])
def test_a_wrong_sign_is_named(bench, name):
    finding, diagnosis = judged(changed(bench, **{name: -1.0}))
    assert finding.status is Status.NOT_TESTABLE
    assert finding.cause.startswith(f"{name} has the wrong sign")
    assert "hand_torque" not in diagnosis.traces


def shifted(recording, **offsets):
    channels = dict(recording.channels)
    for name, offset in offsets.items():
        channels[name] = replace(channels[name], values=offset + channels[name].values)
    return Recording(channels, recording.metadata)


def late(recording, name, seconds):
    channels = dict(recording.channels)
    channels[name] = replace(channels[name], time=channels[name].time + seconds)
    return Recording(channels, recording.metadata)


def test_what_does_not_fit_withholds_the_torque(bench):
    finding, diagnosis = judged(bench, with_parameter("motor_ratio", 1.1))
    assert finding.estimate is None
    assert finding.headline == "Driver's hands: inconsistent, motor_ratio does not fit"
    assert "motor_ratio is 19.8, but the ratio of the angles is 18" in finding.cause
    assert not {"hand_torque", "hands_on", "true_hand_torque"} & set(diagnosis.traces)
    assert not any(name.startswith(("hand_torque", "hands_")) for name in finding.evidence)
    assert "withheld" in diagnosis.remarks["estimate"]
    assert "nis" in diagnosis.traces


@pytest.mark.parametrize("name", ["steering_wheel_angle", "motor_angle_mechanical"])
def test_an_angle_in_degrees_is_named(bench, name):
    finding, _ = judged(changed(bench, **{name: 180.0 / np.pi}))
    assert finding.status is Status.INCONSISTENT
    assert finding.cause.startswith(f"{name} is 57.3 times too large")


def test_an_offset_beyond_what_is_learnt_is_named_with_its_size(bench):
    finding, _ = judged(shifted(bench, driver_torque=-0.5))
    assert finding.status is Status.INCONSISTENT
    assert "driver_torque is 0.50 N·m too low" in finding.cause
    assert judged(shifted(bench, driver_torque=0.1))[0].status.quiet


@pytest.mark.parametrize("name", ["steering_wheel_angle", "driver_torque", "motor_angle_mechanical"])
def test_a_late_signal_is_named_with_its_lag(bench, name):
    finding, _ = judged(late(bench, name, 0.02))
    assert finding.status is Status.INCONSISTENT
    assert finding.cause.startswith(f"{name} is about 2")
    assert finding.evidence[f"{name}_lag_s"] == pytest.approx(
        0.02, rel=0.2
    )  # a torque that jumps is no line in its lag
    assert "stiffness" not in finding.cause


CAR = load("midsize-eps")
UNSIGNED = CASES["unsigned"].cause
SIGNALS = ("steering_wheel_angle", "driver_torque", "motor_torque", "truth_hand_torque")


def by_work(*names, **factors):
    whole = driven.drive(minutes=8.0, seed=3)
    channels = {name: whole[name] for name in SIGNALS if name in (*names, "truth_hand_torque")}
    for name, factor in factors.items():
        channels[name] = replace(channels[name], values=factor * channels[name].values)
    return diagnose(Recording(channels, whole.metadata), CAR, "driver-torque", None)


@pytest.mark.parametrize("name", SIGNALS[:3])
def test_a_wrong_sign_shows_without_the_angle_of_the_motor(name):
    diagnosis = by_work(*SIGNALS, **{name: -1.0})
    finding = diagnosis.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert finding.cause.startswith(f"{name} has the wrong sign")
    assert finding.estimate is None
    assert "hand_torque" not in diagnosis.traces


def test_without_the_torque_of_the_motor_a_wrong_sign_is_a_doubt_and_a_right_one_is_said_to_be_unchecked():
    right, wrong = (by_work(*SIGNALS[:2], driver_torque=factor).findings[0] for factor in (1.0, -1.0))
    assert right.status.quiet
    assert wrong.status.quiet
    assert UNSIGNED in right.warnings
    assert any("a wrong sign of driver_torque" in each for each in wrong.warnings)
    assert not any("a wrong sign" in each for each in right.warnings)
