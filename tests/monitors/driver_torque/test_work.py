"""Wrong signs of torques and of the wheel's angle, by the work on the steering of a car without its motor's angle."""

from dataclasses import replace

import numpy as np
import pytest

import driven
from exact_vehicle import diagnose
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.monitors.driver_torque.block import WorkOverDrive
from tierod.monitors.driver_torque.facts import CASES
from tierod.vehicles import load

CAR = load("midsize-eps")
UNSIGNED = CASES["unsigned"].cause
SIGNALS = ("steering_wheel_angle", "driver_torque", "motor_torque", "truth_hand_torque")


def judged(*names, **factors):
    whole = driven.drive(minutes=8.0, seed=3)
    channels = {name: whole[name] for name in SIGNALS if name in (*names, "truth_hand_torque")}
    for name, factor in factors.items():
        channels[name] = replace(channels[name], values=factor * channels[name].values)
    return diagnose(Recording(channels, whole.metadata), CAR, "driver-torque", None)


@pytest.mark.parametrize("name", SIGNALS[:3])
def test_a_wrong_sign_shows_without_the_angle_of_the_motor(name):
    diagnosis = judged(*SIGNALS, **{name: -1.0})
    finding = diagnosis.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert finding.cause.startswith(f"{name} has the wrong sign")
    assert finding.estimate is None
    assert "hand_torque" not in diagnosis.traces


def test_right_signs_are_left_alone():
    finding = judged(*SIGNALS).findings[0]
    assert finding.status.quiet
    assert UNSIGNED not in finding.warnings


def test_without_the_torque_of_the_motor_a_wrong_sign_is_a_doubt_and_a_right_one_is_said_to_be_unchecked():
    right, wrong = (judged(*SIGNALS[:2], driver_torque=factor).findings[0] for factor in (1.0, -1.0))
    assert right.status.quiet
    assert wrong.status.quiet
    assert UNSIGNED in right.warnings
    assert any("a wrong sign of driver_torque" in each for each in wrong.warnings)
    assert not any("a wrong sign" in each for each in right.warnings)


TIME = np.arange(0.0, 60.0, 0.01)
ANGLE = np.sin(TIME)
ASSISTED = 2.0 * np.cos(TIME)


def over(bar=ASSISTED, motor=0.2 * ASSISTED, angle=ANGLE, pieces=1):
    work = WorkOverDrive(20.0, 100.0)
    for angles, bars, motors in zip(*(np.array_split(each, pieces) for each in (angle, bar, motor)), strict=True):
        work.add(angles, bars, motors)
    return work


def test_pieces_and_gaps_change_nothing():
    whole, cut = (over(bar=-ASSISTED, pieces=pieces).wrong_signs("motor_torque") for pieces in (1, 7))
    assert whole == cut
    gaps = np.where(TIME % 1.0 < 0.1, np.nan, -ASSISTED)
    assert over(bar=gaps).wrong_signs("motor_torque")[0].startswith("driver_torque has the wrong sign")


def test_a_driver_who_pulls_against_lane_keeping_at_times_has_no_wrong_sign():
    assert over(bar=np.where(TIME < 40.0, -ASSISTED, ASSISTED)).wrong_signs("motor_torque") == ()


def test_an_offset_of_a_torque_does_no_work_that_names_a_sign():
    drive = over(bar=np.full(len(TIME), -1.0), motor=np.zeros(len(TIME)))
    assert drive.wrong_signs("motor_torque") == ()
    assert drive.doubts() == ()


def test_a_motor_at_rest_opposes_nobody():
    assert over(motor=np.zeros(len(TIME))).wrong_signs("motor_torque") == ()
    assert over(bar=-ASSISTED, motor=np.full(len(TIME), np.nan)).wrong_signs("motor_torque") == ()
    assert over(bar=-ASSISTED, motor=np.full(len(TIME), np.nan)).doubts()
