"""What a finding says of an error that lasts: its shape and size, when it began, was declared, and ended."""

import math

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle import monitored
from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, recording
from said import estimated, said
from tierod.core.findings import Status
from tierod.diagnosis.fault_memory import FaultMemory
from tierod_lab.papers.motor_angle.bench import RATE, drive
from tierod_lab.papers.motor_angle.sensor_faults import DEGREE, offset

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


@pytest.mark.parametrize("rate", [10.0, -40.0])
def test_a_drift_has_its_rate_and_its_begin(rate):
    (found,) = finding(rate * DEGREE * (TIME - BEGIN) * LATE).findings
    assert math.degrees(found.estimate.value) == pytest.approx(rate, abs=0.1)
    assert f"by a drift of {estimated(found)} electrical" in said(found)
    assert estimated(found).endswith("°/s")
    assert found.since == pytest.approx(BEGIN, abs=0.03)
    assert found.evidence["angle_alarm_from_s"] > BEGIN + 0.1


def test_a_step_that_is_declared_at_once_has_one_time_in_words():
    (found,) = finding(20.0 * DEGREE * LATE).findings
    assert found.declared == pytest.approx(BEGIN, abs=0.1)
    assert found.belated is None
    assert "declared" not in said(found) + repr(found)
    assert found.end is None


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
