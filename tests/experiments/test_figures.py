"""Figures of one drive and of many, against closed forms and published values."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.campaign_rows import row
from tierod_lab.campaign.figures import area_under_curve, share_bound
from tierod_lab.campaign.pools import pool


def test_the_bound_of_a_share():
    assert share_bound(0, 59) == pytest.approx(1.0 - 0.05 ** (1 / 59), rel=1e-9)
    assert share_bound(3, 3) == 1.0
    p = share_bound(2, 20)
    chance = sum(math.comb(20, k) * p**k * (1 - p) ** (20 - k) for k in range(3))
    assert chance == pytest.approx(0.05, rel=1e-9)


@given(st.lists(st.integers(0, 5), min_size=1, max_size=9), st.lists(st.integers(0, 5), min_size=1, max_size=9))
def test_the_area_is_the_share_of_pairs_in_order(lower, higher):
    pairs = [1.0 if high > low else 0.5 if high == low else 0.0 for low in lower for high in higher]
    assert area_under_curve(lower, higher) == pytest.approx(sum(pairs) / len(pairs))


FOUND = {"fault": "step", "size": 4}


def test_detection_times_keep_what_was_missed_and_leave_out_what_was_early():
    rows = [row(seed, **FOUND, detection_s=float(seed), detection_enabled_s=0.5 * seed) for seed in range(1, 20)]
    found = pool([*rows, row(20, **FOUND, verdict="missed"), row(21, **FOUND, verdict="early", false_alarms=1)])
    assert (found.faulty, found.found, found.missed, found.early, found.fault_free) == (21, 19, 1, 1, 0)
    assert found.missed_share == pytest.approx(1 / 20)
    assert (found.detection_median_s, found.detection_p95_s, found.detection_worst_s) == (10.0, 19.0, math.inf)
    assert found.detection_enabled_median_s == 5.0
    assert found.fault_median_s == math.inf


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


def test_drives_that_failed_are_counted_and_nothing_else_is_made_of_them():
    rows = [row(1, outcome="diverged", reason="no longer finite"), row(2, reason="no yaw rate"), row(3)]
    found = pool([*rows, row(4, outcome="failed", reason="no tyre")])
    assert (found.drives, found.diverged, found.failed, found.fault_free) == (4, 1, 2, 1)
    assert found.enabled_share == 0.5
    assert found.judged_share == 0.8


def test_a_drive_whose_fault_never_came_is_a_fault_free_one():
    found = row(1, **FOUND, came=False, verdict="quiet")
    assert (found.faulty, found.given) == (False, "fault-free")
    assert (pool([found]).fault_free, pool([found]).faulty) == (1, 0)
