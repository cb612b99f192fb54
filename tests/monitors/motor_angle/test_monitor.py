"""What a finding says of an error that lasts: its shape and size, when it began, was declared, and ended."""

import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle import monitored
from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, MONITOR, alarms_of, changed, recording
from said import estimated, said
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statuses import code_of
from tierod.diagnosis.fault_memory import FaultMemory
from tierod.monitors.motor_angle.alarms import ALARMS
from tierod_lab.papers.motor_angle.bench import DEGREE, FIVE_DEGREES, RATE, drive, offset

FAULT, HEALTHY = code_of(Status.FAULT), code_of(Status.HEALTHY)
NOT_ENABLED, NOT_READY = code_of(Status.NOT_ENABLED), code_of(Status.NOT_READY)

AT = 62_000
"""A sample at which the drive turns."""


def sensor(change):
    """The drive with another angle from `AT` on, outside the loop."""
    angle = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]].copy()
    angle[AT:] = change(angle[AT:])
    return changed(motor_angle_mechanical=angle)


def test_less_than_a_second_of_fast_turning_is_no_verdict():
    found = monitored.finding(FAULT_FREE().samples[:57_000])
    assert found.status is Status.NOT_ENABLED
    assert "turned fast enough for 0.5 s only, 1 s are needed" in found.cause


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
    assert found["angle"] - AT < 0.05 * RATE


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


ANGLE = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]]
TIME = np.arange(len(ANGLE)) / RATE
BEGIN = 6.2
LATE = TIME >= BEGIN


def finding(error, **more):
    """Of a fault-free drive whose sensor has an error [rad] outside the control loop."""
    return diagnose(recording(changed(motor_angle_mechanical=ANGLE + error)), "motor-bench", "motor-angle", **more)


@pytest.mark.parametrize("begin", [0.0, BEGIN])
@pytest.mark.parametrize(("amplitude", "order"), [(6.0, 1), (6.0, 2), (10.0, 4)])
def test_a_ripple_has_its_amplitude_and_its_order(amplitude, order, begin):
    error = amplitude * DEGREE * np.sin(order * ANGLE + 0.4) * (begin <= TIME)
    (found,) = finding(error).findings
    assert found.status is Status.FAULT
    assert "by a ripple of " in said(found)
    assert f"° electrical, {order} per turn of the shaft" in said(found)
    assert found.estimate.quantity.startswith("amplitude of the ripple")
    assert math.degrees(found.estimate.value) == pytest.approx(amplitude, abs=0.3)


@pytest.mark.parametrize("degrees", [5.0, -20.0, 90.0, -90.0, 180.0])
def test_a_slip_is_a_step_of_its_size(degrees):
    (found,) = finding(degrees * DEGREE * LATE).findings
    assert found.since == pytest.approx(BEGIN, abs=0.01)
    assert "by a step of " in said(found)
    assert abs(math.degrees(found.estimate.value)) == pytest.approx(abs(degrees), abs=0.3)
    assert abs(degrees) == 180.0 or found.estimate.value * degrees > 0.0


@pytest.mark.parametrize(
    ("error", "by", "action"),
    [
        (4.5 * DEGREE * np.sin(8 * ANGLE), "a ripple of {} electrical, 8 per turn of the shaft", "magnet"),
        (
            0.05 * (ANGLE - ANGLE[np.argmax(LATE)]),
            "a gain of {}, so that its error grows with the angle",
            "gain",
        ),
        (10.0 * DEGREE * (TIME - BEGIN), "a drift of {} electrical", "lost readings"),
    ],
)
def test_a_shape_is_that_of_the_difference_whichever_alarm_came_first(error, by, action):
    (found,) = finding(error * LATE).findings
    assert found.cause == "the angle sensor differs from the angle that currents and voltages give"
    assert f"{found.cause} by {by.format(estimated(found))}" in said(found)
    assert action in found.action


def test_an_error_that_ended_has_an_end():
    (found,) = finding(20.0 * DEGREE * (LATE & (TIME < BEGIN + 0.5))).findings
    assert found.status is Status.FAULT
    assert f"by a step of {estimated(found)} electrical; from 6.20 s to {found.end:.2f} s" in said(found)
    assert found.end == pytest.approx(BEGIN + 0.5, abs=0.05)
    assert f"ended at {found.end:.6g} s" in repr(found)


@pytest.mark.parametrize("degrees", [5.0, -5.0])
def test_an_offset_that_disturbed_the_observer_is_lasting(degrees, tmp_path):
    """It jumped beside a slow motor, before the sensor is compared: only currents and voltages agree again."""
    samples, path = drive(42, 9.0, offset(degrees), 2.0).samples, tmp_path / "memory.json"
    found = monitored.finding(samples, memory=path)
    assert found.evidence["model_alarm_from_s"] < found.evidence["angle_alarm_from_s"]
    assert "for a moment" not in said(found)
    assert math.degrees(found.estimate.value) == pytest.approx(degrees, abs=0.1)
    assert f"by {estimated(found)} electrical; since 2.00 s, declared at 5.04 s" in said(found)
    raised = {name for name, each in FaultMemory.opened(path, "motor-bench").entries.items() if each.status & 0x08}
    assert raised == {"motor-angle-offset"}
    begun = monitored.finding(samples[:50_000])
    assert "too little since then to show whether the zero of the angle sensor has moved" in begun.cause
