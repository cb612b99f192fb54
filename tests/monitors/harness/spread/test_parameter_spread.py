"""Uncertain parameters in bands and verdicts, on a monitor whose result is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from rolling_car import OWN, car, monitor
from tierod.core.facts import Verdict
from tierod.core.findings import Estimate, ParameterEffect, Status
from tierod.core.recording import Channel, Recording
from tierod.monitors.diagnose import diagnose
from tierod.monitors.harness.spread.turning import turn_by_estimate
from tierod.vehicles import load


def drive(seconds=20.0):
    time = np.arange(0.0, seconds, 0.02)
    rate = 0.3 * np.sin(time)
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, rate, "rad/s"),
            "vehicle_speed": Channel("vehicle_speed", time, 3.0 + 0.01 * np.cos(7.0 * time), "m/s"),
        }
    )


@pytest.mark.parametrize("seconds", [20.0, 400.0])
def test_band_and_estimate_hold_the_spread_whether_or_not_the_recording_is_longer_than_the_stretch(seconds):
    found = diagnose(drive(seconds), car(1.2, 0.2, 100.0), monitor())
    estimate = found.findings[0].estimate
    assert estimate.value == pytest.approx(0.12, rel=0.01)
    assert estimate.standard_deviation == pytest.approx(np.hypot(OWN, 0.02), rel=0.02)
    band, angle = found.traces["angle_standard_deviation"], found.traces["angle"]
    assert np.allclose(band.upper, np.hypot(OWN, np.maximum(np.abs(angle.lower), np.abs(angle.upper)) / 6.0), rtol=0.05)
    (only,) = found.parameter_effects
    assert (only.name, only.share) == ("rear_distance", 1.0)
    assert only.effect == pytest.approx(0.02, rel=0.02)


def test_the_headline_gives_the_wider_deviation_and_a_warning_what_to_measure():
    finding = diagnose(drive(), car(1.2, 0.2), monitor()).findings[0]
    assert finding.headline.endswith(": healthy, 6.9 ± 1.3 °")
    assert "rear_distance ±0.2 m shifts it by ±1.1 degrees; measure it first" in finding.warnings


def test_nothing_changes_where_parameters_are_exact_or_do_not_matter():
    exact = diagnose(drive(), car(1.2, 0.0), monitor())
    idle = diagnose(drive(), car(1.2, 0.0, 500.0), monitor())
    for each in (exact, idle):
        assert each.findings[0].estimate.standard_deviation == OWN
        assert each.parameter_effects == ()
        assert set(each.traces["angle_standard_deviation"].mean) == {OWN}
        assert each.findings[0].headline == exact.findings[0].headline


def test_a_missing_deviation_is_that_of_the_class_and_said_so():
    found = diagnose(drive(), car(1.2, None), monitor())
    assert found.parameter_effects[0].standard_deviation == pytest.approx(0.09 * 1.2)
    assert "rear_distance has no standard deviation" in found.remarks["parameters"]
    assert "parameters" not in diagnose(drive(), car(1.2, 0.2), monitor()).remarks


def test_a_fault_that_turns_is_suspect_and_names_the_parameter():
    found = diagnose(drive(), car(1.2, 0.2), monitor(limit=0.1))
    finding = found.findings[0]
    assert finding.status is Status.SUSPECT
    assert "rear_distance decides" in finding.headline
    assert "measure rear_distance first" in finding.action
    assert [each.status for each in found.elements] == [Status.SUSPECT]


def test_a_fault_that_does_not_turn_stays():
    found = diagnose(drive(), car(1.2, 0.02), monitor(limit=0.1))
    assert found.findings[0].status is Status.FAULT
    assert [each.status for each in found.elements] == [Status.FAULT]


def test_healthy_turns_where_an_estimate_passes_its_limit_and_not_where_a_car_only_fits_worse():
    turned = diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15)).findings[0]
    assert turned.status is Status.NOT_IDENTIFIABLE
    assert "rear_distance" in turned.cause
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15, misfit=True)).findings[0].status is Status.HEALTHY
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.3)).findings[0].status is Status.HEALTHY


def test_a_spread_of_three_hundred_per_cent_is_a_wide_band_and_no_error():
    found = diagnose(drive(), car(1.2, 3.6, 5100.0), monitor()).findings[0]
    assert found.estimate.standard_deviation > 0.1
    assert np.isfinite(found.estimate.standard_deviation)


def test_the_band_holds_the_truth_of_cars_within_the_spread():
    """95 % of cars whose distance lies within its spread; 200 of them, so that 89 to 99 % are by chance."""
    random, held, exact = np.random.default_rng(20261123), 0, 0
    found = diagnose(drive(), car(1.2, 0.2), monitor()).findings[0].estimate
    for distance in random.normal(1.2, 0.2, 200):
        largest = 0.1 * distance
        error = abs(found.value + random.normal(0.0, OWN) - largest)
        held += error <= 1.96 * found.standard_deviation
        exact += error <= 1.96 * OWN
    assert 0.89 <= held / 200 <= 0.99
    assert exact / 200 < 0.75


@pytest.mark.parametrize(
    ("status", "value", "deviation", "turns"),
    [
        (Status.HEALTHY, 4.0, 1.1, Status.RISING),
        (Status.HEALTHY, 4.0, 0.9, None),
        (Status.FAULT, 9.0, 1.6, Status.HEALTHY),
        (Status.FAULT, 9.0, 1.4, None),
        (Status.NOT_READY, 4.0, 9.0, None),
    ],
)
def test_a_verdict_turns_where_two_deviations_pass_the_limit(status, value, deviation, turns):
    estimate = Estimate("friction", value, 0.1, "N*m", {"nominal": 4.0, "rising": 6.0, "fault": 8.0})
    effect = ParameterEffect("trail", 0.05, 0.01, "m", deviation, "N*m", 1.0)
    found = turn_by_estimate(
        Verdict("friction", status, estimate=estimate), deviation**2, (effect,), load("midsize-eps")
    )
    assert (found and found.status) == turns
    assert found is None or found.names == ("trail",)
