"""A motor ratio that the vehicle file only guesses is taken from the angles, and contradicts no sensor."""

from dataclasses import replace

import pytest

from exact_vehicle import diagnose
from tierod.core.statuses import Status
from tierod.vehicles import load
from tierod_lab.ground import SensorSet, courses, run
from tierod_lab.ground.cars import catalogue as cars

CAR = load("midsize-eps")
CHANNELS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
RATIO = CAR["motor_ratio"]


@pytest.fixture(scope="module")
def drive():
    sensors = SensorSet.production().only(CHANNELS).at_rate(100.0)
    return run(cars.load("midsize-eps").block, courses.load("mixed"), 120.0, 3, sensors).recording


def guessed(value, deviation):
    known = replace(CAR.parameters["motor_ratio"], value=value, standard_deviation=deviation)
    return replace(CAR, parameters={**CAR.parameters, "motor_ratio": known})


def judged(recording, car):
    return diagnose(recording, car, "driver-torque").findings[0]


@pytest.mark.parametrize("value", [21.0, 18.0, 24.0])
def test_a_ratio_within_the_deviation_of_the_file_is_taken_from_the_angles(drive, value):
    exact, finding = judged(drive, CAR), judged(drive, guessed(value, 2.5))
    assert exact.status is finding.status
    assert finding.status is Status.CONSISTENT
    assert any(f"the ratio of the angles is {RATIO:.4g}, which is used: enter motor_ratio = {RATIO:.4g}" in each
               for each in finding.warnings)  # fmt: skip
    assert not any("motor_ratio" in each for each in exact.warnings)
    for name in ("error_against_truth_rms_Nm", "hand_torque_rms_Nm"):
        assert finding.evidence[name] == pytest.approx(exact.evidence[name], rel=0.05)
