"""Odd recordings are as odd as they say."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from driven import odd_drives
from tierod.core.findings import Diagnosis, Element, Episode, Finding
from tierod.core.statuses import Status
from tierod.vehicles import load
from tierod_lab.papers.condition import odd
from tierod_lab.studies.effort import Effort


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


def test_what_ends_is_silent_zero_or_held(drives):
    for how, values in (("read zero", 0.0), ("are silent", np.nan)):
        lost = drives[f"all six sensors {how} from 20 s on"]["tie_rod_force"].values
        np.testing.assert_array_equal(lost[2000:], values)
        assert np.any(lost[:2000] != 0.0)
    held = drives["all six sensors repeat themselves from 20 s on"]["yaw_rate"].values
    assert np.unique(held[1999:]).tolist() == [held[1999]]


def test_a_clock_that_leaps_makes_signals_late_from_then_on(drives):
    leapt, usual = drives["steering bus 0.3 s late from 30 s on"], drives["angle in another gear ratio"]
    read, true = (each["tie_rod_force"].values for each in (leapt, usual))
    np.testing.assert_array_equal(read[:3000], true[:3000])
    np.testing.assert_allclose(read[3100:], true[3070:-30], atol=1e-6)


def test_a_vehicle_halts_on_ice(drives):
    made = drives["braking harder than ice holds"]
    icy, speed = made["truth_road_friction"].values < 0.4, made["truth_speed"].values
    assert np.min(speed[icy]) < 0.1
    assert np.max(speed[icy]) > 3.0


def test_a_vehicle_drives_off_and_its_wheels_spin(drives):
    made = drives["driving off harder than ice holds"]
    icy = (made["truth_road_friction"].values < 0.25) & (made["truth_speed"].values > 0.5)
    mass, radius = (load("smartload").parameters[name].value for name in ("mass", "wheel_radius"))
    pushed = mass * made["longitudinal_acceleration"].values[icy]
    asked = (made["target_drive_torque_left"].values + made["target_drive_torque_right"].values)[icy] / radius
    assert np.median(pushed) < 0.5 * np.median(asked)
    assert np.max(made["truth_speed"].values) > 8.0


def test_every_verdict_that_is_not_fault_free_is_of_a_drive(drives):
    assert set(odd.NOT_HEALTHY) < set(drives)


def made(seconds=60.0):
    return SimpleNamespace(span=(0.0, seconds))


def test_what_the_monitor_says_becomes_a_row():
    episodes = Episode("", 10.0, 12.5), Episode("", 50.0), Episode("", 5.0, 6.0, candidates=("tie_rod_force",))
    off = Element("yaw_rate", "sensor", Status.FAULT, episodes=episodes)
    quiet = Element("tie_rod_force", "sensor", Status.NOT_AVAILABLE)
    diagnosis = Diagnosis((Finding("condition", Status.FAULT, "The yaw rate is off.", cause="why"),), (off, quiet))
    assert odd.row(diagnosis, made()) == ("fault", "yaw_rate", "12.50", "tie_rod_force (not available)", "why")
    assert odd.declared_faulty(diagnosis) == ("yaw_rate",)
    assert odd.row("no wheel speeds", made()) == ("refused", "", "", "", "no wheel speeds")
    assert odd.declared_faulty("no wheel speeds") == ()


def test_a_verdict_must_be_the_right_one_and_have_a_cause():
    fault_free = Diagnosis((Finding("condition", Status.HEALTHY, "Fault-free."),))
    stood, bare = (Diagnosis((Finding("condition", Status.NOT_TESTABLE, "", cause=cause),)) for cause in ("stood", ""))
    assert odd.as_expected("restart in mid-drive", fault_free)
    assert odd.as_expected("standstill", stood)
    assert not odd.as_expected("standstill", bare)
    assert not odd.as_expected("standstill", fault_free)
    assert not odd.as_expected("restart in mid-drive", stood)
    assert not odd.as_expected("standstill", "refused")


def test_the_part_counts_recordings_in_which_something_is_declared_faulty(monkeypatch):
    vehicle = SimpleNamespace(vehicle=None)
    monkeypatch.setattr(odd, "calibrations", lambda *given: {(odd.VARIANTS[odd.BEST].module, 1): vehicle})
    monkeypatch.setattr(odd, "odd_drives", lambda number: {"fine": made(50.0), "odd": made()})
    fault_free = Diagnosis((Finding("condition", Status.HEALTHY, "Fault-free."),))
    off = Element("yaw_rate", "sensor", Status.FAULT, episodes=(Episode("", 58.0),))
    faulty = Diagnosis((Finding("condition", Status.FAULT, "Off."),), (off,))
    monkeypatch.setattr(odd, "said", lambda recording, vehicle: fault_free if recording.span[1] < 55.0 else faulty)
    _, table, wrong, time, unexpected = odd.items(Effort())
    assert [row[1] for row in table.rows] == ["healthy", "fault"]
    assert [claim.measured for claim in (wrong, time, unexpected)] == [1, pytest.approx(2.0), 1]
    assert not any(claim.met for claim in (wrong, time, unexpected))
