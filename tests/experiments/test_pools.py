"""Figures of many drives together."""

import math

import pytest

from experiments.campaign_rows import row
from tierod_lab.campaign.judging import matching
from tierod_lab.campaign.pools import boxes, confusion, pool

FOUND = {"fault": "step", "size": 4}


def test_detection_times_keep_what_was_missed_and_leave_out_what_was_early():
    rows = [row(seed, **FOUND, detection_s=float(seed), detection_enabled_s=0.5 * seed) for seed in range(1, 20)]
    found = pool([*rows, row(20, **FOUND, verdict="missed"), row(21, **FOUND, verdict="early", false_alarms=1)])
    assert (found.faulty, found.found, found.missed, found.early, found.fault_free) == (21, 19, 1, 1, 0)
    assert found.missed_share == pytest.approx(1 / 20)
    assert (found.detection_median_s, found.detection_p95_s, found.detection_worst_s) == (10.0, 19.0, math.inf)
    assert found.detection_enabled_median_s == 5.0
    assert found.fault_median_s == math.inf


def test_a_fault_that_was_never_judged_is_not_found():
    found = pool([row(1, **FOUND, verdict="not judged", detection_s=math.inf), row(2, **FOUND, detection_s=3.0)])
    assert (found.missed, found.not_judged, found.missed_share) == (0, 1, 0.5)
    assert found.detection_worst_s == math.inf


def test_false_alarms_are_counted_over_the_hours_that_were_judged():
    quiet = pool([row(seed) for seed in range(30)])
    assert quiet.fault_free_hours == pytest.approx(5.0)
    assert quiet.fault_free_judged_hours == pytest.approx(4.0)
    assert quiet.false_alarm_rate == 0.0
    assert quiet.false_alarm_bound == pytest.approx(-math.log(0.05) / 4.0)
    noisy = pool([row(1, verdict="false alarm", false_alarms=2), row(2, **FOUND, false_alarms=1)])
    assert noisy.false_alarms == 3
    assert noisy.false_alarm_rate == pytest.approx(3 / 0.2)


def test_errors_are_pooled_over_samples_and_the_worst_drive_is_reported():
    found = pool([row(1), row(2, **FOUND)])
    assert found.bias_fault_free == pytest.approx(0.1)
    assert found.bias_faulty == pytest.approx(-0.3)
    assert found.bias == pytest.approx((0.1 * 200 - 0.3 * 100) / 300)
    assert found.deviation_fault_free == pytest.approx(0.2)
    assert found.largest_bias == pytest.approx(0.1)


def test_areas_between_drives_and_within_them():
    fault_free, faulty = [row(1, value=4.0), row(2, value=9.0)], [row(1, **FOUND), row(2, **FOUND, area=0.9)]
    assert pool(faulty, fault_free).area == 0.5
    assert pool(fault_free + faulty).area == 0.5
    assert pool(faulty, fault_free).smallest_area == 0.9
    assert math.isnan(pool(faulty).area)
    assert math.isnan(pool(fault_free).smallest_area)


def test_drives_that_failed_are_counted_and_nothing_else_is_made_of_them():
    rows = [row(1, outcome="diverged", reason="no longer finite"), row(2, reason="no yaw rate"), row(3)]
    found = pool([*rows, row(4, outcome="failed", reason="no tyre")])
    assert (found.drives, found.diverged, found.failed, found.fault_free) == (4, 1, 2, 1)
    assert found.enabled_share == 0.5
    assert found.judged_share == 0.8


def test_nothing_comes_of_nothing():
    found = pool([])
    assert found.drives == 0
    assert math.isnan(found.missed_share)
    assert math.isnan(found.detection_worst_s)
    assert math.isnan(found.false_alarm_bound)


def test_the_confusion_of_states():
    rows = [row(1), row(2), row(3, verdict="not judged"), row(1, **FOUND), row(2, outcome="diverged", **FOUND)]
    assert confusion(rows) == {"fault-free": {"healthy": 2, "not ready": 1}, "step 4": {"fault": 1, "no verdict": 1}}


def test_boxes_of_estimates_by_state():
    fault_free, faulty = boxes([row(1), row(1, **FOUND), row(2, outcome="diverged")])
    assert (fault_free.state, fault_free.truth, fault_free.estimates, fault_free.median) == (
        "fault-free",
        4.0,
        6,
        pytest.approx(4.1),
    )
    assert (faulty.state, faulty.truth, faulty.estimates, faulty.median) == ("step 4", 8.0, 3, pytest.approx(7.7))
    assert faulty.bias == pytest.approx(-0.3)


def test_rows_are_chosen_by_levels():
    rows = [row(1), row(2), row(1, **FOUND), row(1, monitor="other")]
    assert matching(rows, {"fault": "step", "size": 4}) == [rows[2]]
    assert matching(rows, {"seed": [1, 2]}, "friction") == rows[:3]
    assert matching(rows, {"tyre": "winter"}) == []


def test_a_drive_whose_fault_never_came_is_a_fault_free_one():
    found = row(1, **FOUND, came=False, verdict="quiet")
    assert (found.faulty, found.given) == (False, "fault-free")
    assert (pool([found]).fault_free, pool([found]).faulty) == (1, 0)
