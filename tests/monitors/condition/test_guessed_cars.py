"""The condition of real cars of which mass and wheelbase are known and all else is typical of a class."""

import pytest

from shared_data import shared_data
from tierod.core.statuses import Status
from tierod.io.readers import read
from tierod.monitors.diagnose import diagnose
from tierod.vehicles import load
from tierod_lab.ground.faults import injected
from tierod_lab.papers.condition.drives import OFFSET, Injected
from tierod_lab.papers.own_car.brochure import brochure_car


@pytest.fixture(scope="module")
def tight_bends():
    path = shared_data("revsted_slip_angle", "obd.csv")
    return read(path, channel_map=load("revsted-car").channel_map)


@pytest.mark.parametrize("kind", ["small", "midsize", "large", "suv", "van"])
def test_a_guessed_file_accuses_no_sensor_of_a_fault_free_drive(tight_bends, kind):
    finding = diagnose(tight_bends, brochure_car("guessed", kind, 1700.0, 2.7), "condition").findings[0]
    assert finding.status is Status.HEALTHY


def test_a_fault_is_named_with_a_guessed_file(tight_bends):
    fault = Injected("yaw_rate", OFFSET, 0.3, tight_bends.span[0] + 10.0, tight_bends.span[0] + 14.0).fault
    car = brochure_car("guessed", "midsize", 1700.0, 2.7)
    found = diagnose(injected(tight_bends, [fault]), car, "condition")
    assert found.findings[0].status is Status.FAULT
    assert [each.name for each in found.elements if each.status is Status.FAULT] == ["yaw_rate"]
