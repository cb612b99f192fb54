"""The gain of the torque sensors is part of the standard deviation, wherever it is shown."""

from __future__ import annotations

import dataclasses
import math

import pytest

from tierod.core.findings import Finding
from tierod.core.recording import Recording
from tierod.core.statuses import Status
from tierod.monitors.baseline import Baseline
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import Parameter, Vehicle, load
from tierod_lab.ground import drive, lock_to_lock

TRUE = 4.0


@pytest.fixture(scope="module")
def fault_free() -> Recording:
    return drive(minutes=5.0, friction=TRUE, seed=52)


def scaled(recording: Recording, gain: float) -> Recording:
    torques = (recording["driver_torque"], recording["motor_torque"])
    return recording.with_channels([dataclasses.replace(each, values=gain * each.values) for each in torques])


def calibrated(deviation: float) -> Vehicle:
    car = load("midsize-eps")
    known = Parameter("torque_gain_deviation", deviation, "", None, "calibration")
    return dataclasses.replace(car, parameters={**car.parameters, known.name: known})


def judged(recording: Recording, vehicle: Vehicle | str = "midsize-eps") -> Finding:
    return diagnose(recording, vehicle, "friction").findings[0]


@pytest.mark.parametrize("gain", [0.86, 1.0, 1.14])
def test_the_interval_holds_the_truth_for_a_gain_within_the_assumption(fault_free, gain):
    found = judged(scaled(fault_free, gain))
    assert found.estimate is not None
    assert abs(found.estimate.value - TRUE) < 1.96 * found.estimate.standard_deviation
    assert "torque gains ± 8 % included" in found.details


def with_limit_deviations(**deviations: float) -> Vehicle:
    car = load("midsize-eps")
    changed = {
        name: dataclasses.replace(car.parameters[name], standard_deviation=each) for name, each in deviations.items()
    }
    return dataclasses.replace(car, parameters={**car.parameters, **changed})


def test_beside_a_baseline_the_margin_holds_the_deviation_of_each_limit_and_says_so(fault_free):
    """Level of 8 N·m, so that the limits of the vehicle file act first."""
    own = Baseline("midsize-eps", "friction, pre-sliding", 8.0, 0.01, "N*m", 100.0)
    recording, found = scaled(fault_free, 1.4), {}
    for rising, fault in ((0.0, 0.0), (1.2, 1.875)):
        car = with_limit_deviations(rising_friction=rising, fault_friction=fault)
        found[rising] = diagnose(recording, car, "friction", baseline=own).findings[0]
        reference = found[rising].estimate.reference
        for name, limit, deviation in (("rising", 4.8, rising), ("fault", 7.5, fault)):
            at = reference[name]
            assert at - 2.0 * math.hypot(0.08 * at, deviation) == pytest.approx(limit, abs=0.05)
    ends = {rising: f"(up to {each.estimate.reference['rising']:.2f} N·m)" for rising, each in found.items()}
    assert found[0.0].status.quiet
    assert f"within the margin of torque gain and estimate {ends[0.0]}" in " ".join(found[0.0].details)
    assert f"within the margin of torque gain, estimate and limit {ends[1.2]}" in " ".join(found[1.2].details)
    assert "only 0.70 times its baseline" in found[1.2].cause


def test_friction_far_below_nominal_is_healthy_with_a_remark_and_its_cure(fault_free):
    car = load("midsize-eps")
    known = {name: each for name, each in car.parameters.items() if not name.startswith("assist_")}
    without_map = dataclasses.replace(car, parameters=known)
    low, usual = (judged(each, without_map) for each in (scaled(fault_free, 0.6), fault_free))
    assert low.status is usual.status is Status.HEALTHY
    share = low.estimate.value / 4.0
    assert f"only {share:.2f} times nominal" in low.details
    assert "the gains of driver_torque and motor_torque" in low.cause
    assert "another car" in low.cause
    assert "judge against this car's baseline" in low.action
    assert "times nominal" not in " ".join((*usual.details, usual.cause, *usual.warnings))


@pytest.mark.parametrize("against", ["nominal", "baseline"])
def test_a_loop_far_narrower_than_expected_is_not_as_expected(against):
    test = lock_to_lock(TRUE, hoist=True, seed=6)
    own = None
    if against == "baseline":
        own = Baseline("midsize-eps", "hysteresis, hoist", TRUE, 0.02, "N*m", 60.0, rate=1.0)
    low, usual = (
        diagnose(each, "midsize-eps", "hysteresis", "hoist", baseline=own, spread=False).findings[0]
        for each in (scaled(test, 0.6), test)
    )
    assert low.status is usual.status is Status.HEALTHY
    assert "only 0.5" in low.cause
    assert "the gains of driver_torque and motor_torque" in low.cause
    assert "calibrate driver_torque and motor_torque" in low.action
    assert ("--baseline" in low.action) == (own is None)
    assert usual.cause == "the loop is as wide as expected"
    assert usual.action == "none"


def test_a_gain_that_may_hide_a_fault_leaves_no_verdict(fault_free):
    found = judged(fault_free, calibrated(0.6))
    assert found.status is Status.NOT_IDENTIFIABLE
    assert found.headline == "Friction: not identifiable, torque_gain_deviation decides the verdict"
    assert found.action.startswith("give a fault-free drive of this car as baseline")
    assert judged(fault_free, calibrated(0.2)).status is Status.HEALTHY
