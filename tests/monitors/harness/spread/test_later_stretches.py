"""Parameters that begin to matter later in a recording, and the cut of the recording, which must not matter."""

from __future__ import annotations

import numpy as np
import pytest

from rolling_car import OWN, car, monitor
from tierod.core.recording import Channel, Recording
from tierod.monitors.harness.run import Run


def recording(seconds: float, turns_from: float, straight_again: float = np.inf) -> Recording:
    """A straight road, and a weave from a time on."""
    time = np.arange(0.0, seconds, 0.02)
    turning = (time > turns_from) & (time < straight_again)
    return Recording(
        {
            "yaw_rate": Channel("yaw_rate", time, np.where(turning, 0.3, 0.0005) * np.sin(time), "rad/s"),
            "vehicle_speed": Channel("vehicle_speed", time, 3.0 + 0.01 * np.cos(7.0 * time), "m/s"),
        }
    )


def judged(whole: Recording, vehicle, cuts):
    watched = monitor()
    run = Run(watched, watched.variants["only"], vehicle, uncertain=True)
    for begin, end in zip([0.0, *cuts], [*cuts, np.inf], strict=True):
        run.add(whole.slice(begin, end))
    return run.finish()


@pytest.mark.parametrize(("turns_from", "until"), [(60.0, 360.0), (170.0, 470.0), (700.0, 1200.0)])
def test_a_parameter_that_matters_only_later_widens_the_band(turns_from, until):
    found = judged(recording(until, turns_from), car(1.2, 0.2, 100.0), [])
    estimate = found.findings[0].estimate
    assert estimate.standard_deviation == pytest.approx(np.hypot(OWN, 0.02), rel=0.02)
    assert [each.name for each in found.parameter_effects] == ["rear_distance"]
    band = found.traces["angle_standard_deviation"]
    late = band.time > until - 50.0
    assert np.max(band.upper[late]) == pytest.approx(np.hypot(OWN, 0.02), rel=0.05)


def test_what_was_found_stays_where_nothing_moves_the_result_any_more():
    found = judged(recording(600.0, 0.0, straight_again=70.0), car(1.2, 0.2), [])
    assert found.findings[0].estimate.standard_deviation == pytest.approx(np.hypot(OWN, 0.02), rel=0.02)


@pytest.mark.parametrize("turns_from", [0.0, 170.0])
def test_bands_do_not_depend_on_how_a_recording_is_cut(turns_from):
    whole, vehicle = recording(500.0, turns_from), car(1.2, 0.2, 500.0)
    chance = np.random.default_rng(8)
    at_once = judged(whole, vehicle, [])
    for cuts in (np.arange(120.0, 500.0, 120.0), np.arange(2.013, 500.0, 2.0), np.sort(chance.uniform(1.0, 499.0, 90))):
        found = judged(whole, vehicle, cuts.tolist())
        assert found.findings[0].estimate == at_once.findings[0].estimate
        assert found.parameter_effects == at_once.parameter_effects
        mine, other = (each.traces["angle_standard_deviation"] for each in (found, at_once))
        assert (mine.upper.tolist(), mine.lower.tolist()) == (other.upper.tolist(), other.lower.tolist())
