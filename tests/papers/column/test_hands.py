"""Scores of the hands on states made up by hand, and on a run of a bench and of the car."""

import numpy as np
import pytest

from tierod_lab.ground.courses.bench import BenchHands
from tierod_lab.papers.column.hand_datasets import Held, Natural, hands_on_and_off, natural_drives
from tierod_lab.papers.column.handled_bench import STEP, drawn, score

COURSE = BenchHands(time=60.0, seed=8)


def perfect(delay):
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


def test_benches_differ_from_the_vehicle_file_by_the_share():
    bench = drawn(5, 0.1, 60.0)
    assert abs(bench.plant.wheel_inertia / 0.035 - 1.0) == pytest.approx(0.1)
    assert abs(bench.gain - 1.0) == pytest.approx(0.1)


def test_hands_of_a_bench_are_found():
    found = hands_on_and_off(Held("usual", 2000, 60.0))
    delays = [row["delay"] for row in found if row["event"] == "grab"]
    assert delays
    assert max(delays) < 500.0
    assert sum(row["wrong"] for row in found) == 0.0


@pytest.mark.slow
def test_hands_that_leave_the_wheel_of_a_car_are_found():
    drive, *releases = natural_drives(Natural("straight", "bench, 1000 Hz", 1, 60.0))
    assert drive["torque"] < 0.1
    assert drive["off_while_held"] == 0.0
    assert [row["release"] < 1.0 for row in releases] == [True, True]
