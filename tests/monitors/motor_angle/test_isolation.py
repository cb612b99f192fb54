"""What a finding accuses: the sensor with its noise, or currents and voltages where these contradict each other."""

import math

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding
from said import estimated, said
from tierod.core.findings import Status
from tierod.diagnosis.fault_memory import FaultMemory
from tierod_lab.papers.motor_angle.bench import RATE, drive, offset

ANGLE = FAULT_FREE().samples[:, COLUMN["motor_angle_mechanical"]]
TIME = np.arange(len(ANGLE)) / RATE
CURRENTS, VOLTAGES = (tuple(f"motor_{name}_{axis}" for axis in ("alpha", "beta")) for name in ("current", "voltage"))


def times(factor, names, samples=None):
    """A drive in which some signals are multiplied."""
    samples = (FAULT_FREE().samples if samples is None else samples).copy()
    for name in names:
        samples[:, COLUMN[name]] *= factor
    return samples


def noisy(degrees, until=math.inf):
    noise = np.random.default_rng(9).normal(size=len(ANGLE)) * (until > TIME)
    return changed(motor_angle_mechanical=ANGLE + math.radians(degrees) * noise)


@pytest.mark.parametrize("degrees", [0.25, 2.0, 8.0])
def test_noise_of_the_angle_has_its_size(degrees, tmp_path):
    found = finding(noisy(degrees), memory=tmp_path / "memory.json")
    assert found.status is Status.FAULT
    assert f"the readings of the motor's angle sensor have noise of {estimated(found)} mechanical" in said(found)
    assert math.degrees(found.estimate.value) == pytest.approx(degrees, rel=0.05)
    assert found.estimate.quantity.startswith("noise of the readings")
    assert found.since < 0.1
    assert found.end is None
    raised = FaultMemory.opened(tmp_path / "memory.json", "motor-bench").entries
    assert {name for name, each in raised.items() if each.status & 0x08} == {"motor-angle-offset"}


@pytest.mark.parametrize(("degrees", "warned"), [(0.02, False), (0.1, False), (0.16, True)])
def test_a_quiet_sensor_has_the_smallest_noise_that_is_named(degrees, warned):
    found = finding(noisy(degrees))
    limit = found.evidence["smallest_named_sensor_noise_mechanical_rad"]
    assert 0.1 < math.degrees(limit) < 0.2
    assert (found.evidence["sensor_noise_mechanical_rad"] > limit) == warned
    assert warned == ("noise of 0.16" in said(found) + " ".join(found.warnings))


def test_currents_that_grow_alike_are_blamed_and_not_the_angle(tmp_path):
    found = finding(times(1.0 + np.clip(TIME / 3.0 - 1.0, 0.0, 1.0), CURRENTS), memory=tmp_path / "memory.json")
    assert "currents and voltages contradict the model of the motor; they fit " in found.cause
    assert "as with currents" in found.cause
    assert "angle sensor" not in said(found) + found.action
    assert found.estimate is None
    raised = FaultMemory.opened(tmp_path / "memory.json", "motor-bench").entries
    assert {name for name, each in raised.items() if each.status & 0x08} == {"motor-currents"}


def test_a_wrong_scale_beside_an_offset_of_the_angle_has_both():
    found = finding(times(2.0, CURRENTS, drive(101, 8.0, offset(10.0), 5.0).samples))
    assert found.status is Status.SUSPECT
    assert "these contradict each other too" in found.cause
    assert "an angle sensor that is off by +10.0° electrical" in found.cause
