"""Wrong signs of torques and of the wheel's angle, by the work on the steering of a car without its motor's angle."""

from dataclasses import replace

import pytest

import driven
from exact_vehicle import diagnose
from tierod.core.findings import Status
from tierod.core.recording import Recording
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


def test_without_the_torque_of_the_motor_a_wrong_sign_is_a_doubt_and_a_right_one_is_said_to_be_unchecked():
    right, wrong = (judged(*SIGNALS[:2], driver_torque=factor).findings[0] for factor in (1.0, -1.0))
    assert right.status.quiet
    assert wrong.status.quiet
    assert UNSIGNED in right.warnings
    assert any("a wrong sign of driver_torque" in each for each in wrong.warnings)
    assert not any("a wrong sign" in each for each in right.warnings)
