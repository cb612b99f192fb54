"""Scores are checked on states made up by hand; the parts themselves run in their quick form."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tierod.core.claims import Claim, claims_document
from tierod.core.graph import scan
from tierod.monitors.driver_torque.hands import OFF, HandsMonitor
from tierod.vehicles import load
from tierod_lab.ground.courses.bench import BenchHands
from tierod_lab.papers.column import hands, natural_drives
from tierod_lab.papers.column.handled_bench import STEP, HeldRecord, design_thresholds, drawn, score, together
from tierod_lab.studies.effort import Effort

COURSE = BenchHands(time=60.0, seed=8)


def perfect(delay):
    """States of a monitor that is late by the same in every change [s]."""
    time = np.arange(0.0, 60.0, STEP)
    return (np.searchsorted(COURSE.switches, time - delay, side="right") % 2).astype(float)


def test_a_late_monitor_is_late_by_what_it_is():
    found = score(perfect(0.2), COURSE)
    assert found.grabs == pytest.approx(0.2, abs=2 * STEP)
    assert found.releases == pytest.approx(0.2, abs=2 * STEP)
    assert (found.false_on, found.false_off) == (0, 0)
    assert len(found.firmness) == len(found.grabs)


def test_flickers_count_as_false_and_doubts_do_not():
    hands_ = perfect(0.2)
    start, end = COURSE.switches[:2]
    middle = round(0.5 * (start + end) / STEP)
    hands_[middle : middle + 50] = 0.5
    assert score(hands_, COURSE).false_off == 0
    hands_[middle : middle + 50] = 0.0
    flickered = score(hands_, COURSE)
    assert (flickered.false_on, flickered.false_off) == (0, 1)


def test_hands_that_are_never_found_are_late_for_ever():
    found = score(np.zeros(60_000), COURSE)
    assert np.all(np.isinf(found.grabs))


def test_scores_add_up():
    one = score(perfect(0.1), COURSE)
    both = together([one, one])
    assert len(both.grabs) == 2 * len(one.grabs)
    assert both.seconds == 2.0 * one.seconds


def test_benches_differ_from_the_vehicle_file_by_the_share():
    bench = drawn(5, 0.1, 60.0)
    assert abs(bench.plant.wheel_inertia / 0.035 - 1.0) == pytest.approx(0.1)
    assert abs(bench.gain - 1.0) == pytest.approx(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("part", [hands, natural_drives])
def test_the_part_runs_quickly(part):
    claims = [item for item in part.items(Effort(quick=True, processes=1)) if isinstance(item, Claim)]
    assert claims
    assert claims_document(claims)


def test_a_monitor_is_designed_for_both_changes():
    draw, time = np.random.default_rng(4), np.arange(0.0, 60.0, 1e-3)
    held = (np.floor(time / 5.0) % 2.0).astype(float)
    noise = draw.standard_normal((3, len(time)))
    hand = held * 0.15 * np.convolve(noise[0], np.hanning(150) / 7.5, "same")
    rate = lfilter([0.0, 1e-3 / 0.035], [1.0, -np.exp(-1e-3 * 0.2286 / 0.035)], hand)
    samples = np.column_stack([np.cumsum(rate) * 1e-3 + 1e-4 * noise[1], 0.01 * noise[2]])
    monitor = HandsMonitor.of_vehicle(load("column-bench"), 1e-3)
    design = design_thresholds(monitor, [HeldRecord(samples, held)], 0.1)
    assert all(each > 0.0 for each in design.thresholds)
    assert np.any(scan(monitor, samples)["hands"] == OFF)
