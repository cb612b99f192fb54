"""Uncertain parameters in bands and verdicts, on a monitor whose result is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rolling_car import OWN, car, monitor
from tierod.core.findings import Status
from tierod.core.recording import Channel, Recording
from tierod.monitors.diagnose import diagnose
from tierod.monitors.run import Run

COARSE = replace(monitor(), lane_rate=10.0)
"""The monitor at 50 Hz, whose lanes see every fifth sample."""


def drive(seconds=20.0, turns=(0.0, np.inf)):
    """A weave between two times, and a straight road before and after."""
    time = np.arange(0.0, seconds, 0.02)
    turning = (time >= turns[0]) & (time < turns[1])
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, np.where(turning, 0.3, 0.0005) * np.sin(time), "rad/s"),
            "vehicle_speed": Channel("vehicle_speed", time, 3.0 + 0.01 * np.cos(7.0 * time), "m/s"),
        }
    )


@pytest.mark.parametrize("watched", [monitor(), COARSE], ids=["every sample", "every fifth"])
@pytest.mark.parametrize("turns", [(0.0, np.inf), (0.0, 70.0), (101.0, 140.0), (170.0, 190.0)])
def test_a_parameter_widens_band_and_estimate_whenever_it_acts(turns, watched):
    found = diagnose(drive(200.0, turns), car(1.2, 0.2, 100.0), watched)
    estimate = found.findings[0].estimate
    assert estimate.value == pytest.approx(0.12, rel=0.01)
    assert estimate.standard_deviation == pytest.approx(np.hypot(OWN, 0.02), rel=0.02)
    (only,) = found.parameter_effects
    assert (only.name, only.share) == ("rear_distance", 1.0)
    assert only.effect == pytest.approx(0.02, rel=0.02)
    band, angle = found.traces["angle_standard_deviation"], found.traces["angle"]
    widest = np.hypot(OWN, np.maximum(np.abs(angle.lower), np.abs(angle.upper)) / 6.0)
    assert np.allclose(band.upper, widest, rtol=0.05, atol=0.0 if watched is not COARSE else 0.002)


def test_the_squares_of_independent_parameters_add_up():
    found = diagnose(drive(), car(1.2, 0.2, 170.0), monitor(laden=True))
    assert found.findings[0].estimate.standard_deviation == pytest.approx(
        np.sqrt(OWN**2 + 0.02**2 + 0.012**2), rel=0.02
    )
    assert [each.name for each in found.parameter_effects] == ["rear_distance", "mass"]


@pytest.mark.parametrize("watched", [monitor(), COARSE], ids=["every sample", "every fifth"])
def test_bands_do_not_depend_on_how_a_recording_is_cut(watched):
    whole, vehicle = drive(300.0, (30.0, 250.0)), car(1.2, 0.2, 500.0)

    def judged(cuts):
        run = Run(watched, watched.variants["only"], vehicle, uncertain=True)
        for begin, end in zip([0.0, *cuts], [*cuts, np.inf], strict=True):
            run.add(whole.slice(begin, end))
        return run.finish()

    at_once = judged([])
    for cuts in (np.arange(2.013, 300.0, 2.0), np.arange(1.7, 300.0, 33.313)):
        found = judged(cuts.tolist())
        assert found.findings[0].estimate == at_once.findings[0].estimate
        assert found.parameter_effects == at_once.parameter_effects
        mine, other = (each.traces["angle_standard_deviation"] for each in (found, at_once))
        assert (mine.upper.tolist(), mine.lower.tolist()) == (other.upper.tolist(), other.lower.tolist())


def test_the_finding_gives_the_wider_deviation_and_what_to_measure():
    finding = diagnose(drive(), car(1.2, 0.2), monitor()).findings[0]
    assert "6.9 ± 1.3 °" in finding.headline
    assert any("rear_distance ±0.2 m shifts it by ±1.1 degrees; measure it first" in each for each in finding.warnings)


def test_a_missing_deviation_is_that_of_the_class_and_said_so():
    found = diagnose(drive(), car(1.2, None), monitor())
    assert found.parameter_effects[0].standard_deviation == pytest.approx(0.09 * 1.2)
    assert "rear_distance has no standard deviation" in found.remarks["parameters"]
    assert "parameters" not in diagnose(drive(), car(1.2, 0.2), monitor()).remarks


@pytest.mark.parametrize("watched", [monitor(limit=0.1), replace(monitor(limit=0.1), lane_rate=10.0)])
def test_a_fault_that_turns_is_suspect_and_names_the_parameter(watched):
    found = diagnose(drive(), car(1.2, 0.2), watched)
    finding = found.findings[0]
    assert finding.status is Status.SUSPECT
    assert "rear_distance decides" in finding.headline
    assert "measure rear_distance first" in finding.action
    assert [each.status for each in found.elements] == [Status.SUSPECT]


def test_healthy_turns_where_an_estimate_passes_its_limit_and_not_where_a_car_only_fits_worse():
    turned = diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15)).findings[0]
    assert turned.status is Status.NOT_IDENTIFIABLE
    assert "rear_distance" in turned.cause
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.15, misfit=True)).findings[0].status is Status.HEALTHY
    assert diagnose(drive(), car(1.2, 0.2), monitor(limit=0.3)).findings[0].status is Status.HEALTHY


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
