"""The monitor of sideslip as users see it: what it says, and why it says nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.sideslip.definition import TRACES
from tierod_lab.ground import SensorSet, run
from tierod_lab.ground.cars.catalogue import load as load_car
from tierod_lab.ground.courses.manoeuvres import SineSteer

VARIANT = "two-stage-kalman"
NEEDED = ("vehicle_speed", "yaw_rate", "road_wheel_angle", "motor_current", "lateral_acceleration")


@pytest.fixture(scope="module")
def drive() -> Recording:
    course = SineSteer(speed=20.0, amplitude=math.radians(1.3) * 17.0, frequency=0.3, periods=6)
    recording = run(load_car("steer-by-wire").block, course, seed=3, sensors=SensorSet.bench().at_rate(100.0)).recording
    return Recording(
        {name: recording[name] for name in (*NEEDED, "truth_sideslip_angle", "truth_steering_wheel_angle")}
    )


def changed(drive, **factors):
    channels = {name: drive[name] for name in drive.names}
    for name, factor in factors.items():
        channels[name] = dataclasses.replace(channels[name], values=factor * channels[name].values)
    return Recording(channels)


def without(drive, *names):
    return Recording({name: drive[name] for name in drive.names if name not in names})


def finding(recording, variant=VARIANT, vehicle="steer-by-wire"):
    return diagnose(recording, vehicle, "sideslip", variant).findings[0]


@pytest.mark.parametrize(
    "variant", ["conventional-kalman", "conventional-poles", "two-stage-kalman", "two-stage-poles"]
)
def test_it_shows_the_largest_angle_with_its_deviation_and_error(drive, variant):
    diagnosis = diagnose(drive, "steer-by-wire", "sideslip", variant)
    found = diagnosis.findings[0]
    assert found.status.quiet
    largest = np.abs(drive["truth_sideslip_angle"].values).max()
    assert abs(found.estimate.value) == pytest.approx(largest, abs=0.01)
    assert found.evidence["enabled_s"] > 20.0
    assert found.evidence["error_against_truth_rms_rad"] < math.radians(0.3)
    assert found.evidence["truth_within_band_share"] > 0.9
    assert {name for name, _ in TRACES.values()} < set(diagnosis.traces)
    assert "true_sideslip_angle" in diagnosis.traces
    assert diagnosis.traces["sideslip_angle"].unit == "rad"


@pytest.mark.parametrize(
    ("channel", "called"),
    [
        ("road_wheel_angle", "steering angle"),
        ("yaw_rate", "yaw rate"),
        ("lateral_acceleration", "lateral acceleration"),
        ("motor_current", "steering torque"),
    ],
)
def test_a_wrong_sign_is_named_from_the_data_and_the_value_withheld(drive, channel, called):
    diagnosis = diagnose(changed(drive, **{channel: -1.0}), "steer-by-wire", "sideslip", VARIANT)
    found = diagnosis.findings[0]
    assert found.status is Status.NOT_TESTABLE
    assert f"the sign of {called} contradicts" in found.cause
    assert "sideslip_angle" not in diagnosis.traces


def test_without_torque_it_names_the_channels_and_the_variant_that_needs_none(drive):
    found = finding(without(drive, "motor_current"))
    assert found.status is Status.NOT_AVAILABLE
    assert "motor_torque or motor_current" in found.cause
    assert "combined" in found.action


def test_a_band_that_does_not_hold_the_truth_is_suspect(drive):
    found = finding(changed(drive, truth_sideslip_angle=4.0))
    assert found.status is Status.INCONSISTENT
    assert found.evidence["truth_within_band_share"] < 0.8
    assert "the 95 % band contains the recorded truth for" in found.cause
    assert found.headline == "Sideslip: inconsistent, the band misses the recorded truth"
