import math

import numpy as np
import pytest

from tierod.core.claims import Claim
from tierod.methods.detectors.stopping_rules import CusumRule
from tierod.monitors.motor_angle.comparison import ANGLE_DRIFT
from tierod_lab.papers.motor_angle import run_length
from tierod_lab.papers.motor_angle.healthy_drives import (
    HealthyDrive,
    HealthyDrives,
    bench_monitor,
    healthy_drives,
    other_motor,
)
from tierod_lab.papers.motor_angle.observer_drives import FLUX, INDUCTANCE, RESISTANCE
from tierod_lab.papers.motor_angle.run_length import TriedLength, items, simulated, tried_lengths
from tierod_lab.studies.effort import Effort


@pytest.fixture(scope="module")
def driven():
    """One course, driven by three motors."""
    return healthy_drives(1, 40, Effort(processes=1), seconds=7.0)


def test_fault_free_drives_are_counted_in_hours(driven):
    found = driven
    assert found.hours == pytest.approx(3 * 7.0 / 3600.0)
    assert 0.0 < found.turning < 3 * 2.0 / 3600.0
    assert found.alarms == 0
    assert 0.0 < found.greatest < 0.1
    assert [len(drive.residuals) for drive in found.drives] == pytest.approx(
        [1e3 * drive.turning for drive in found.drives], rel=0.01
    )


def test_motors_in_a_row_spread_over_their_ranges():
    p = bench_monitor().observer.parameters
    drawn = [other_motor(bench_monitor(), number).observer.parameters for number in range(3, 63)]
    for name, (low, high) in (
        ("motor_resistance", RESISTANCE),
        ("motor_flux", FLUX),
        ("motor_inductance", INDUCTANCE),
    ):
        shares = np.sort([(getattr(p, name) / getattr(each, name) - low) / (high - low) for each in drawn])
        assert np.abs(shares - (np.arange(60) + 0.5) / 60.0).max() < 0.06


def test_white_residuals_alarm_as_often_as_designed():
    rule = CusumRule(0.5)
    length, alarms = simulated(rule, rule.threshold_for(100.0), 200_000, 1)
    assert alarms > 1000
    assert length == pytest.approx(100.0, rel=0.1)


def made_drives(count, seed, deviation):
    """Residuals that follow their last value: as coloured as those of the bench."""
    noise = np.random.default_rng(seed).normal(size=(20_000, count))
    for k in range(1, len(noise)):
        noise[k] = 0.9 * noise[k - 1] + math.sqrt(1.0 - 0.81) * noise[k]
    records = (deviation * noise.T).astype(np.float32)
    return HealthyDrives(tuple(HealthyDrive(20.0, False, record) for record in records), 60.0)


def test_a_threshold_of_coloured_residuals_holds_on_others():
    found = {each.wanted: each for each in tried_lengths(made_drives(240, 4, ANGLE_DRIFT / 1.5), scale=1.0)}
    assert found[20.0].alarms >= 100
    assert found[20.0].measured == pytest.approx(20.0, rel=0.2)
    assert found[20.0].interval[0] < found[20.0].measured < found[20.0].interval[1]
    assert found[600.0].threshold > found[20.0].threshold


def test_without_an_alarm_only_a_bound_is_left():
    tried = TriedLength(600.0, 1.0, 0, 6000.0)
    assert math.isnan(tried.measured)
    assert tried.interval[0] == pytest.approx(6000.0 / -math.log(0.025), rel=1e-6)
    assert tried.interval[1] == math.inf


def test_what_was_not_counted_is_not_judged(driven, monkeypatch):
    twice = HealthyDrives(2 * driven.drives, driven.seconds)
    monkeypatch.setattr(run_length, "healthy_drives", lambda *given: twice)
    claims = {item.id: item for item in items(Effort(quick=True, processes=1)) if isinstance(item, Claim)}
    assert claims["run-length.white"].met is None
    assert not [name for name in claims if name.startswith("run-length.coloured")], "too few alarms to measure them"
    assert claims["faults.none-false"].met


@pytest.mark.slow
def test_the_study_meets_its_run_lengths():
    claims = {item.id: item for item in items(Effort()) if isinstance(item, Claim)}
    for name in ("run-length.white", "faults.none-false"):
        assert claims[name].met, name
