"""Sensors that no declaration accuses, and that are not fault-free either."""

import math

import pytest

from monitors.condition.motion_alone import drive
from tierod.core.findings import Status
from tierod.core.recording import Recording
from tierod.monitors.diagnose import diagnose
from tierod.papers.condition.faults import LOSS, Injected
from tierod.proving_ground.faults import injected
from tierod.vehicles import load

SEED = 91
"""Its yaw rate stays below 0.01 rad/s from 15 to 25 s."""


@pytest.fixture(scope="module")
def straight():
    made = drive(SEED).slice(0.0, 40.0)
    return Recording(dict(made.channels))


def test_a_yaw_rate_that_is_lost_on_a_straight_road_is_not_called_fault_free(straight):
    fault = Injected("yaw_rate", LOSS, math.nan, 15.0, 25.0).fault
    found = diagnose(injected(straight, [fault]), load("rav4"), "condition")
    (yaw,) = (each for each in found.elements if each.name == "yaw_rate")
    assert yaw.status is Status.NOT_TESTABLE
    assert "stayed the same from 15.0" in yaw.cause
    finding = found.findings[0]
    assert finding.status is Status.NOT_TESTABLE
    assert finding.headline.startswith("Yaw rate: its reading stayed the same from 15.0")


def test_a_fault_free_straight_road_is_healthy(straight):
    assert diagnose(straight, load("rav4"), "condition").findings[0].status is Status.HEALTHY
