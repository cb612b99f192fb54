"""The study of fleets in small: it counts what was drawn."""

import numpy as np
import pytest

from tierod_lab.fleet.writing import shipped_law
from tierod_lab.papers.fleet import study
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Frame, metric


def test_vehicle_years_and_delays_are_counted():
    quiet = Frame.of("years", study.over_years(study.Years(shipped_law(), 5, 60, 1)))
    assert metric("sum years", quiet) == pytest.approx(60.0, rel=0.03)
    assert metric("sum alarms", quiet) == 0.0
    ramps = Frame.of("years", study.over_years(study.Years(shipped_law(), 5, 60, 1, "ramp")))
    delays = ramps.where({"delay": ">= 0"})
    assert len(delays) == 3
    assert ramps["years"][0] < quiet["years"][0]
    assert metric("max delay", delays) < 60.0
    assert np.array_equal(delays["within"], delays["delay"] <= 30.0)


def test_false_alarms_are_counted_with_tyres_that_move_the_estimate_too():
    fleets = study.years(shipped_law(), Effort(quick=True))
    assert [(each.per_week, each.change) for each in fleets[:3]] == [(1, "none"), (2, "none"), (7, "none")]
    (strict,) = (each for each in fleets if each.other_tyres)
    assert (strict.law.winter, strict.law.winter_deviation, strict.per_week) == (0.0, 0.03, 7)
    assert strict.law.drive_deviation == shipped_law().drive_deviation


def test_a_batch_is_named():
    (row,) = study.over_fleets(study.Fleet(shipped_law(), 1.0, 6))
    assert (row["named"], row["others"]) == (1.0, 0.0)
    assert row["log10_odds"] > 2.0
    assert row["effect"] == pytest.approx(1.0, abs=0.3)
