"""The gain of the torque sensors is part of the standard deviation, wherever it is shown."""

from __future__ import annotations

import dataclasses
import json

import pytest

from tierod.core.findings import Finding
from tierod.core.recording import Recording
from tierod.monitors.diagnose import diagnose
from tierod.proving_ground import drive
from tierod.proving_ground.scenarios import load as load_scenario
from tierod.report import to_json
from tierod.vehicles import Parameter, Vehicle, load

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
    assert f"± {found.estimate.standard_deviation:.2f} N·m (torque gains ± 8 % included)" in found.headline


def test_a_vehicle_file_that_states_less_narrows_the_interval(fault_free):
    assumed, known, exact = (judged(fault_free, calibrated(each)) for each in (0.08, 0.03, 0.0))
    assert "torque gains ± 3 % included" in known.headline
    sizes = [each.estimate.standard_deviation for each in (assumed, known, exact)]
    assert sizes == sorted(sizes, reverse=True)
    for each, share in ((assumed, 0.08), (known, 0.03)):
        own = each.evidence["deviation_by_torque_gains_Nm"]
        assert own == pytest.approx(share * each.estimate.value)
        assert each.estimate.assumed == {"torque_gain_deviation": own}


def test_the_document_and_the_course_hold_the_same_deviation(fault_free):
    diagnosis = diagnose(fault_free, "midsize-eps", "friction")
    (finding,) = json.loads(to_json(diagnosis))["findings"]
    whole = finding["estimate"]["standard_deviation"]
    assert finding["estimate"]["assumed"]["torque_gain_deviation"] < whole
    course = diagnosis.traces["friction_torque_standard_deviation"].mean
    assert course[-1] == pytest.approx(whole, rel=0.15)


def test_the_torque_of_the_hands_holds_the_gain_too():
    recording = dataclasses.replace(load_scenario("hands-off"), faults=()).with_run(None, 72).run().recording
    found = diagnose(recording, "midsize-eps", "driver-torque").findings[0]
    exact = diagnose(recording, calibrated(0.0), "driver-torque").findings[0]
    assert "(torque gain ± 8 % included)" in found.headline
    assert found.estimate.standard_deviation > exact.estimate.standard_deviation
