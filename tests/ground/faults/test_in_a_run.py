"""Faults in a whole virtual car, from the control loop to the recording."""

import json

import numpy as np
import pytest

from tierod_lab.ground import EpsCar, SensorSet, SingleTrack, run
from tierod_lab.ground.courses.natural import NaturalDrive
from tierod_lab.ground.faults import (
    AtDistance,
    AtTime,
    Fault,
    Intermittent,
    Noise,
    Offset,
    Step,
    TorqueLoss,
    When,
)

SECONDS = 6.0
CAR = EpsCar(SingleTrack())
LEVEL = "steering.friction.level"


def driven(*faults, seed=3):
    course = NaturalDrive(name="natural", seed=1, time=SECONDS)
    return run(CAR, course, None, seed, SensorSet.ideal(100.0), faults)


def differing(one, other, name):
    first, second = one.recording[name], other.recording[name]
    return first.time[first.values != second.values]


@pytest.fixture(scope="module")
def fault_free():
    return driven()


@pytest.mark.parametrize(
    ("fault", "channel"),
    [
        (Fault(LEVEL, Step(8.0), AtTime(3.0)), "truth_friction_torque"),
        (Fault("road.bank_angle", Offset("2 deg"), AtTime(3.0)), "truth_bank_angle"),
        (Fault("loop.driver_torque", Offset(1.0), AtTime(3.0)), "truth_motor_target_torque"),
        (Fault("motor_torque", TorqueLoss(), AtTime(3.0)), "truth_motor_torque"),
        (Fault("yaw_rate", Offset(0.1), AtTime(3.0)), "yaw_rate"),
    ],
    ids=lambda part: part if isinstance(part, str) else part.label,
)
def test_nothing_differs_before_a_fault_begins(fault_free, fault, channel):
    outcome = driven(fault)
    assert 3.0 <= differing(outcome, fault_free, channel).min() <= 3.3
    (window,) = outcome.windows
    assert (window["start"], window["end"]) == (3.0, SECONDS)


def test_a_parameter_is_seen_in_the_truth(fault_free):
    level = driven(Fault(LEVEL, Step(8.0), AtTime(2.0), 1.5)).recording["truth_friction_torque"]
    inside = (level.time >= 2.0) & (level.time < 3.5)
    assert set(level.values[inside]) == {8.0}
    assert set(level.values[~inside]) == {4.0}


def test_a_fault_of_a_recorded_signal_leaves_the_car_alone(fault_free):
    outcome = driven(Fault("sensor.driver_torque", Offset(1.0), AtTime(3.0)))
    assert not len(differing(outcome, fault_free, "truth_steering_wheel_angle"))
    np.testing.assert_allclose(
        outcome.recording["driver_torque"].values[300:] - fault_free.recording["driver_torque"].values[300:], 1.0
    )


@pytest.mark.parametrize(
    "trigger", [When("vehicle_speed > 1 m/s", 0.3), AtDistance(20.0)], ids=lambda each: type(each).__name__
)
def test_a_condition_is_met_on_the_way(trigger, fault_free):
    outcome = driven(Fault(LEVEL, Step(8.0), trigger))
    (window,) = outcome.windows
    assert 0.0 < window["start"] < SECONDS
    came = differing(outcome, fault_free, "truth_friction_torque").min()
    assert came == pytest.approx(window["start"], abs=0.011)


def test_a_run_is_repeated_to_the_bit_and_can_be_written():
    faults = (Fault("driver_torque", Intermittent(Noise(0.5))), Fault(LEVEL, Step(8.0), AtTime(1.0)))
    one, other = driven(*faults), driven(*faults)
    assert not any(len(differing(one, other, name)) for name in one.recording.channels)
    result = json.loads(json.dumps(one.recording.metadata))["faults"]
    assert [each["behaviour"]["kind"] for each in result] == ["intermittent", "step"]
