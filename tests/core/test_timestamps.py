"""Faults of time stamps: dropped, sorted, kept or refused, always said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.errors import InputError
from tierod.core.timestamps import LATE, finite_or_missing, infinite_note, order, paced


def test_good_stamps_are_left_alone():
    time = np.arange(5.0)
    put = order(time, "x")
    assert put.index is None
    assert put.notes == ()
    assert put(time) is time


def test_stamps_that_are_no_numbers_are_dropped():
    put = order(np.array([0.0, np.nan, 1.0, np.inf, 2.0]), "x")
    assert put.time.tolist() == [0.0, 1.0, 2.0]
    assert put(np.arange(5)).tolist() == [0, 2, 4]
    assert put.notes == ("2 samples without a time stamp left out",)


def test_late_samples_are_sorted():
    put = order(np.array([0.0, 0.02, 0.01, 0.03]), "x")
    assert put.time.tolist() == [0.0, 0.01, 0.02, 0.03]
    assert put(np.arange(4)).tolist() == [0, 2, 1, 3]
    assert "1 samples that arrived late" in put.notes[0]
    assert put.behind == pytest.approx(0.01)


def test_dropped_and_late_together():
    put = order(np.array([np.nan, 0.0, 0.02, 0.01]), "x")
    assert put(np.arange(4)).tolist() == [1, 3, 2]


def test_a_clock_set_back_is_refused():
    with pytest.raises(
        InputError,
        match=r"time of x jumps back from 5\.0+ s to 1\.0+ s at sample 3; .*cut the.*if a counter rolled over",
    ):
        order(np.array([0.0, 5.0, 1.0, 2.0]), "x")


def test_a_slow_slide_back_is_refused():
    time = np.concatenate(([0.0, 10.0], 10.0 - 0.4 * np.arange(1, 4)))
    with pytest.raises(InputError, match="jumps back"):
        order(time, "x")


def test_a_clock_that_stands_still_is_refused():
    with pytest.raises(InputError, match="stands still at 3 s for all 4 samples"):
        order(np.full(4, 3.0), "x")


def test_equal_stamps_are_kept_and_said():
    put = order(np.array([0.0, 1.0, 1.0, 1.0, 2.0]), "x")
    assert len(put.time) == 5
    assert "2 equal time stamps (the clock stands at 1 s for 3 samples)" in put.notes[0]


def test_no_stamp_at_all():
    with pytest.raises(InputError, match="no time stamp of x is a number"):
        order(np.full(3, np.nan), "x")


@given(st.lists(st.floats(0.0, LATE / 2), min_size=2, max_size=50))
def test_disorder_within_the_limit_always_ends_in_order(offsets):
    time = 0.1 * np.arange(len(offsets)) + np.array(offsets)
    if len(np.unique(time)) < 2:
        return
    put = order(time, "x")
    assert (np.diff(put.time) >= 0.0).all()
    assert sorted(put(np.arange(len(time))).tolist()) == list(range(len(time)))


def test_infinite_values_are_missing():
    values, count = finite_or_missing(np.array([1.0, np.inf, -np.inf, np.nan]))
    assert np.isnan(values).tolist() == [False, True, True, True]
    assert infinite_note(count) == "2 infinite values taken as missing"
    assert infinite_note(0) == ""


def test_bursts_are_paced_again():
    sent = 0.01 * np.arange(1000)
    delivered = 0.03 * np.ceil(sent / 0.03 - 1e-9)
    again = paced(delivered, 0.01)
    assert np.abs(again - sent)[:900].max() < 1e-9
    assert (np.diff(again) > 0.0).all()


def test_lost_samples_stay_a_gap():
    sent = np.concatenate((0.01 * np.arange(300), 5.0 + 0.01 * np.arange(300)))
    delivered = 0.03 * np.ceil(sent / 0.03 - 1e-9)
    steps = np.diff(paced(delivered, 0.01))
    assert steps.max() > 1.9
    assert np.median(steps) == pytest.approx(0.01)


@pytest.mark.parametrize("drift", [-2e-4, 2e-4])
def test_a_drifting_clock_is_followed(drift):
    sent = 0.01 * (1.0 + drift) * np.arange(20000)
    polls = np.cumsum(np.random.default_rng(3).uniform(0.005, 0.035, 20000))
    delivered = polls[np.searchsorted(polls, sent)]
    assert np.abs(delivered - sent).max() > 0.03
    assert np.abs(paced(delivered, 0.01) - sent)[:19800].max() < 0.004


def test_a_period_must_be_positive():
    with pytest.raises(InputError, match="positive period"):
        paced(np.arange(3.0), 0.0)
