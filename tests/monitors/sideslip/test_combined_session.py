"""What the monitor's usual variant estimates beside the sideslip."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from said import said
from tierod_lab.ground import SensorSet, run
from tierod_lab.ground.cars.catalogue import load
from tierod_lab.ground.courses.course import Adhesion
from tierod_lab.ground.courses.manoeuvres import AngleRamp, SineSteer
from tierod_lab.ground.scenarios import load as load_scenario


def driven(course):
    return run(load("steer-by-wire").block, course, seed=4, sensors=SensorSet.bench().at_rate(100.0)).recording


@pytest.fixture(scope="module")
def drive():
    return driven(SineSteer(speed=22.0, amplitude=math.radians(25.0), frequency=0.4, periods=10))


@pytest.fixture(scope="module")
def demonstrator():
    return load_scenario("demonstrator-healthy").with_run(60.0, 5).run().recording


def test_it_shows_what_the_drive_contains(drive):
    diagnosis = diagnose(drive, "steer-by-wire", "sideslip")
    found = diagnosis.findings[0]
    assert found.status.quiet
    assert found.evidence["error_against_truth_rms_rad"] < math.radians(0.1)
    assert found.evidence["front stiffness, identified share"] > 0.9
    assert found.evidence["restarts"] == 0.0
    assert found.evidence["limit_announced_s"] == 0.0
    assert "front stiffness" in diagnosis.remarks["estimate"]
    assert 0.0 < diagnosis.consistency["nis_band_low"] < diagnosis.consistency["nis_band_high"]


def test_the_limit_of_grip_is_reported():
    slippery = (Adhesion(left=0.35, right=0.35),)
    course = AngleRamp(speed=20.0, angle=math.radians(60.0), rate=math.radians(5.0), conditions=slippery)
    found = diagnose(driven(course), "steer-by-wire", "sideslip").findings[0]
    assert "close to its largest force" in said(found)
    assert 3.0 < found.evidence["limit_first_announced_at_s"] < 14.0
    assert found.evidence["largest_front_friction_used"] > 0.8


@pytest.mark.parametrize("wrong", ["held at 5 Hz", "by a third", "by 15 degrees"])
def test_beside_a_wrong_steering_angle_no_limit_is_announced(demonstrator, wrong):
    angle = demonstrator["steering_wheel_angle"]
    values = {
        "held at 5 Hz": np.repeat(angle.values[::20], 20)[: len(angle.values)],
        "by a third": 1.33 * angle.values,
        "by 15 degrees": angle.values + math.radians(15.0),
    }
    changed = demonstrator.with_channels([dataclasses.replace(angle, values=values[wrong])])
    found = diagnose(changed, "smartload", "sideslip").findings[0]
    assert "largest force" not in said(found)
