"""The monitor of sideslip as users see it: what it tells, and why it tells nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tierod.findings import Status
from tierod.monitors.run import diagnose
from tierod.monitors.sideslip.car_signals import FromCarSignals
from tierod.monitors.sideslip.session import TRACES
from tierod.proving_ground import SensorSet, run
from tierod.proving_ground.cars.catalogue import load as load_car
from tierod.proving_ground.courses.open_loop import SineSteer
from tierod.recording import Recording
from tierod.vehicles import load

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
def test_it_tells_the_largest_angle_with_its_deviation_and_error(drive, variant):
    diagnosis = diagnose(drive, "steer-by-wire", "sideslip", variant)
    found = diagnosis.findings[0]
    assert found.status is Status.HEALTHY
    largest = np.abs(drive["truth_sideslip_angle"].values).max()
    assert abs(found.estimate.value) == pytest.approx(largest, abs=0.01)
    assert found.evidence["enabled_s"] > 20.0
    assert found.evidence["error_against_truth_rms_rad"] < math.radians(0.3)
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


def test_without_an_angle_it_says_which_one_it_needs(drive):
    found = finding(without(drive, "road_wheel_angle"))
    assert found.status is Status.NOT_AVAILABLE
    assert "steering_wheel_angle" in found.cause


def test_the_steering_wheel_stands_in_for_the_road_wheels(drive):
    wheel = dataclasses.replace(drive["truth_steering_wheel_angle"], name="steering_wheel_angle")
    found = finding(without(drive, "road_wheel_angle").with_channels([wheel]))
    assert found.status is Status.HEALTHY
    assert found.evidence["error_against_truth_rms_rad"] < math.radians(0.5)


def test_without_torque_it_names_the_channels_and_the_variant_that_needs_none(drive):
    found = finding(without(drive, "motor_current"))
    assert found.status is Status.NOT_AVAILABLE
    assert "motor_torque or motor_current" in found.cause
    assert "combined" in found.action


def test_a_car_that_hardly_rolls_is_not_enabled(drive):
    found = finding(changed(drive, vehicle_speed=0.01))
    assert found.status is Status.NOT_ENABLED
    assert "fastest" in found.cause


def test_parameters_that_do_not_fit_are_told_by_the_innovations(drive):
    found = finding(changed(drive, yaw_rate=3.0))
    assert found.status is Status.NOT_IDENTIFIABLE
    assert "do not fit" in found.headline


def test_torque_and_current_give_the_same_torque_at_the_road_wheels():
    class Told:
        Sample = type("Sample", (), {"_fields": ("road_wheel_torque",), "__new__": lambda cls, torque: torque})

        def init(self):
            return None

        def step(self, state, sample):
            return state, sample

    block = FromCarSignals.of_vehicle(Told(), load("steer-by-wire"))
    nan = math.nan
    of_torque = block.step(None, block.Sample(motor_torque=0.12, motor_current=nan))[1]
    of_current = block.step(None, block.Sample(motor_torque=nan, motor_current=2.0))[1]
    assert of_torque == pytest.approx(of_current) == pytest.approx(17.0 * 3.0 * 75.0 * 0.7 * 0.12)
