"""The lock-to-lock test from recording to finding."""

import pytest

from tierod.errors import InputError
from tierod.findings import Status
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import diagnose
from tierod.proving_ground import drive, lock_to_lock


@pytest.mark.parametrize("support", MONITORS["hysteresis"].variants)
@pytest.mark.parametrize(
    ("added", "status"), [(0.0, Status.HEALTHY), (1.5, Status.RISING), (4.0, Status.FAULT), (8.5, Status.FAULT)]
)
def test_the_increase_over_the_unfaulted_loop_is_found(tmp_path, support, added, status):
    level, hoist = tmp_path / "level.json", support == "hoist"
    diagnose(lock_to_lock(4.0, hoist, seed=1), "midsize-eps", "hysteresis", support, own_level=level)
    test = lock_to_lock(4.0 + added, hoist, seed=2)
    finding = diagnose(test, "midsize-eps", "hysteresis", support, own_level=level).findings[0]
    assert finding.evidence["increase_Nm"] == pytest.approx(added, abs=0.3)
    assert finding.status is status


def test_on_the_hoist_it_is_held_against_nominal():
    finding = diagnose(lock_to_lock(9.0, hoist=True), "midsize-eps", "hysteresis").findings[0]
    assert finding.status is Status.FAULT
    assert finding.estimate.value == pytest.approx(9.0, abs=0.3)
    assert finding.estimate.standard_deviation > 0.0


def test_on_the_ground_nothing_can_be_said_without_the_unfaulted_loop():
    finding = diagnose(lock_to_lock(4.0, hoist=False), "midsize-eps", "hysteresis", "ground").findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert "scrub" in finding.cause
    assert "--own-level" in finding.action


def test_a_drive_is_no_lock_to_lock_test():
    with pytest.raises(InputError, match="vehicle moves"):
        diagnose(drive(minutes=2.0), "midsize-eps", "hysteresis")
