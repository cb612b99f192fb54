"""The friction monitor on drives: what it finds, how soon, and what it does not judge."""

import math

import numpy as np
import pytest

from monitors.friction.study_drives import signals
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.core.statuses import STATUSES
from tierod.monitors.friction.definition import FrictionMonitor
from tierod.vehicles import load

VEHICLE = load("midsize-eps")
MONITOR = FrictionMonitor.of_vehicle(VEHICLE)
ANGLE, RATE, DRIVER, MOTOR, YAW, LATERAL, SPEED = range(7)
MINUTES = 9.0
"""Duration of a drive whose friction changes half-way, when its level is learnt [min]."""
CHANGE = 30.0 * MINUTES


def statuses(result):
    return np.array([STATUSES[round(code)] for code in result["verdict.running"]], dtype=object)


def enabled_delay(result, *wanted):
    """Enabled time [s] from the change to the first verdict of one of these."""
    enabled = np.cumsum(result["estimate.enabled"]) / 100.0
    change = round(100.0 * CHANGE)
    assert not np.isin(statuses(result)[:change], (Status.RISING, Status.FAULT)).any()
    reached = np.flatnonzero(np.isin(statuses(result)[change:], wanted))
    return enabled[change + reached[0]] - enabled[change] if len(reached) else math.inf


@pytest.mark.parametrize("seed", [1001, pytest.param(1002, marks=pytest.mark.slow)])
def test_a_step_to_12_5_is_a_fault_within_12_s_enabled(seed):
    result = scan(MONITOR, signals(seed, 4.0, 12.5, minutes=MINUTES))
    assert enabled_delay(result, Status.FAULT) <= 12.0
    finding = MONITOR.finding(result)
    assert finding.status is Status.FAULT
    assert finding.since == pytest.approx(CHANGE, abs=30.0)
    assert finding.estimate.value == pytest.approx(12.5, rel=0.04)
    assert finding.evidence["ratio_to_baseline"] == pytest.approx(12.5 / 4.0, rel=0.04)


def finding_after(change, level=4.0, monitor=MONITOR):
    samples = signals(1001, level).copy()
    change(samples)
    return monitor.finding(scan(monitor, samples))


def turned(*columns):
    def change(samples):
        samples[:, list(columns)] *= -1.0

    return change


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        (turned(DRIVER), Status.NOT_IDENTIFIABLE, "opposite signs"),
        (turned(DRIVER, MOTOR), Status.NOT_IDENTIFIABLE, "negative"),
        (turned(LATERAL, YAW), Status.NOT_IDENTIFIABLE, "self-aligning torque is negative"),
        (lambda s: s[:, DRIVER].fill(0.1), Status.NOT_ENABLED, "driver's torque was too small for 100%"),
        (lambda s: s[:, SPEED].fill(1.0), Status.NOT_ENABLED, "stood or rolled slowly for 100%"),
        (lambda s: s[:, [RATE]].fill(0.0) or s[:, RATE].fill(0.0), Status.NOT_ENABLED, "hardly turned for 100%"),
        (lambda s: s[:, YAW].fill(np.nan), Status.NOT_AVAILABLE, "the signals were never all present at once"),
        (lambda s: s[6000:].fill(np.nan), Status.NOT_READY, " s only, 50 s are needed"),
    ],
)
def test_without_a_fault_free_basis_the_value_is_withheld(change, status, words):
    finding = finding_after(change)
    assert finding.status is status
    assert finding.status.exit_code == 2
    assert words in finding.cause
    assert finding.action
    assert finding.estimate is None


def scaled(factor, *columns):
    def change(samples):
        samples[:, list(columns)] *= factor

    return change


def late(seconds, *columns):
    def change(samples):
        shift, which = round(100 * seconds), list(columns)
        samples[shift:, which] = samples[:-shift, which]

    return change


@pytest.mark.parametrize("level", [4.0, pytest.param(8.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (scaled(-1.0, RATE), "damping"),
        (scaled(180.0 / math.pi, YAW), "self-aligning torque"),
        (scaled(1.0 / 9.81, LATERAL), "damping"),
        (scaled(0.0, LATERAL), "torque"),
    ],
    ids=["wrong sign of the rate", "yaw rate in degrees", "lateral acceleration in g", "no lateral acceleration"],
)
def test_signals_that_contradict_each_other_are_not_judged(level, change, words):
    finding = finding_after(change, level)
    assert finding.status is Status.NOT_IDENTIFIABLE
    assert finding.estimate is None
    assert words in finding.cause
    assert "unit" in finding.action or "sign" in finding.action


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (late(0.1, DRIVER, MOTOR), "inertia is negative"),
        (late(0.1, ANGLE, RATE), "the angle is probably about 100 ms later"),
        (late(0.2, YAW, LATERAL), "yaw rate and lateral acceleration are late"),
    ],
    ids=["torques", "angle", "yaw"],
)
def test_late_signals_are_reported_by_what_was_learnt(change, words):
    assert not any("late" in warning for warning in finding_after(lambda samples: None).warnings)
    assert any(words in warning for warning in finding_after(change).warnings)
