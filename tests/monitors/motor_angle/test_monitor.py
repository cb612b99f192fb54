import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, MONITOR, alarms_of, changed
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statement import code_of
from tierod.monitors.motor_angle.alarms import ALARMS
from tierod_lab.papers.motor_angle.bench import RATE, drive
from tierod_lab.papers.motor_angle.sensor_faults import FAULTS, FIVE_DEGREES

FAULT, HEALTHY = code_of(Status.FAULT), code_of(Status.HEALTHY)
NOT_ENABLED, NOT_READY = code_of(Status.NOT_ENABLED), code_of(Status.NOT_READY)

BEGIN = 62_000
"""A sample at which the drive turns."""

BY_NAME = {fault.name: fault for fault in FAULTS}


def sensor(change):
    """The drive with another angle from `BEGIN` on, outside the loop."""
    angle = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]].copy()
    angle[BEGIN:] = change(angle[BEGIN:])
    return changed(motor_angle_mechanical=angle)


@pytest.mark.parametrize("seed", [3, 4])
def test_a_fault_free_drive_raises_nothing_and_is_called_fault_free(seed):
    found = scan(MONITOR, FAULT_FREE(seed).samples)
    assert found["statement.status"][:49_990].min() == NOT_READY
    assert set(np.unique(found["statement.status"][50_000:])) == {NOT_ENABLED, HEALTHY}
    assert found["compared.known"].sum() > 10_000
    assert alarms_of(FAULT_FREE(seed).samples) == {}


@pytest.mark.parametrize("size", [FIVE_DEGREES, -FIVE_DEGREES])
def test_an_offset_of_five_degrees_electrical_is_found_while_turning(size):
    found = alarms_of(sensor(lambda angle: angle + size))
    assert found["angle"] - BEGIN < 0.05 * RATE


@pytest.mark.parametrize("name", ["stuck", "sine and cosine swapped", "current phases b and c swapped"])
def test_what_makes_the_drive_stall_is_found(name):
    faulty = drive(3, 8.0, BY_NAME[name], BEGIN / RATE)
    found = alarms_of(faulty.samples)
    assert found
    assert min(found.values()) - BEGIN in range(400)
    assert scan(MONITOR, faulty.samples)["statement.status"][-1] == FAULT


def test_a_fault_is_stated_with_kind_beginning_and_magnitude():
    found = scan(MONITOR, sensor(lambda angle: angle + FIVE_DEGREES))
    fault = found["statement.status"] == FAULT
    first = int(np.argmax(fault))
    names = [each.name for each in ALARMS]
    assert names[int(found["statement.kind"][first]) - 1] == "angle"
    assert found["statement.since"][first] == pytest.approx(first / RATE, abs=1e-6)
    assert found["statement.since"][~fault].max() == -1.0
    assert found["statement.evidence"][fault].min() >= 1.0
    assert found["statement.evidence"][~fault].max() < 1.0
    turning = fault & (found["statement.magnitude"] != 0.0)
    assert np.abs(found["statement.magnitude"][turning]).mean() == pytest.approx(4.0 * FIVE_DEGREES, rel=0.2)
