"""Odd recordings are as odd as they say."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tierod.findings import Diagnosis, Element, Finding, Status
from tierod.studies.condition import odd
from tierod.studies.condition.odd_drives import all_lost, odd_drives
from tierod.studies.registry import Effort


@pytest.fixture(scope="module")
def drives():
    return odd_drives(1)


def test_standing_reversing_and_sliding_are_driven(drives):
    assert np.max(np.abs(drives["standstill"]["truth_speed"].values)) < 0.05
    assert np.min(drives["three-point turns with reversing"]["truth_speed"].values) < -1.0
    ice = drives["ice on a bend"]
    assert np.min(ice["truth_road_friction"].values) == pytest.approx(0.36, abs=0.01)
    assert len(ice["yaw_rate"].values) == 6000
    assert np.max(np.abs(ice["truth_lateral_offset"].values)) > 2.0


def test_a_restart_begins_in_motion_at_time_zero(drives):
    begun = drives["restart in mid-drive"]
    assert begun["yaw_rate"].time[0] == 0.0
    assert begun["truth_speed"].values[0] > 3.0


def test_wiring_and_logging_are_odd_and_no_more(drives):
    swapped, late = drives["wheels swapped"], drives["steering bus 0.3 s late"]
    usual = drives["angle in another gear ratio"]
    left, right = (swapped[f"wheel_speed_rear_{side}"].values for side in ("left", "right"))
    np.testing.assert_array_equal(left, usual["wheel_speed_rear_right"].values)
    np.testing.assert_array_equal(right, usual["wheel_speed_rear_left"].values)
    np.testing.assert_allclose(late["tie_rod_force"].values[100:], usual["tie_rod_force"].values[70:-30], atol=1e-6)
    np.testing.assert_array_equal(late["yaw_rate"].values, usual["yaw_rate"].values)
    assert "yaw_rate" not in drives["without yaw rate"]
    gaps = drives["gaps of 0.3 s in all signals"]
    assert np.mean(np.isnan(gaps["yaw_rate"].values)) == pytest.approx(0.03, abs=0.002)


def test_everything_can_be_lost_at_once():
    lost = all_lost(1)
    assert np.all(lost["tie_rod_force"].values[2000:] == 0.0)
    assert np.any(lost["tie_rod_force"].values[:2000] != 0.0)


def test_what_the_monitor_says_becomes_a_row():
    episode = Element("yaw_rate", "sensor", Status.FAULT)
    quiet = Element("tie_rod_force", "sensor", Status.NOT_AVAILABLE)
    told = Diagnosis((Finding("condition", Status.FAULT, "The yaw rate is off.", cause="why"),), (episode, quiet))
    assert odd.row(told) == ("fault", "yaw_rate", "tie_rod_force (not available)", "why")
    assert odd.accused(told) == ("yaw_rate",)
    assert odd.row("no wheel speeds") == ("refused", "", "", "no wheel speeds")
    assert odd.accused("no wheel speeds") == ()


def test_the_part_counts_recordings_in_which_something_is_accused(monkeypatch):
    vehicle = SimpleNamespace(vehicle=None)
    monkeypatch.setattr(odd, "calibrations", lambda *given: {(odd.VARIANTS[odd.BEST].module, 1): vehicle})
    monkeypatch.setattr(odd, "odd_drives", lambda number: {"fine": 0, "odd": 1})
    monkeypatch.setattr(odd, "all_lost", lambda number: 1)
    sound = Diagnosis((Finding("condition", Status.HEALTHY, "Sound."),))
    faulty = Diagnosis((Finding("condition", Status.FAULT, "Off."),), (Element("yaw_rate", "sensor", Status.FAULT),))
    monkeypatch.setattr(odd, "said", lambda recording, vehicle: (sound, faulty)[recording])
    *_, table, claim = odd.items(Effort())
    assert [row[1] for row in table.rows] == ["healthy", "fault", "fault"]
    assert (claim.measured, claim.met) == (1, False)
