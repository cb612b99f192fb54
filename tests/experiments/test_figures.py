"""The statistics against closed forms and published values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod_lab.campaign.figures import (
    Moments,
    area_under_curve,
    paired,
    pooled,
    quantile,
    rate_bound,
    share_bound,
)


def test_no_event_bounds_the_rate_by_three_over_the_time():
    assert rate_bound(0, 1.0) == pytest.approx(-math.log(0.05), rel=1e-12)
    assert rate_bound(0, 40.0) == pytest.approx(2.9957323 / 40.0, rel=1e-6)


@pytest.mark.parametrize(("events", "bound"), [(1, 4.74), (2, 6.30), (5, 10.51), (10, 16.96)])
def test_bounds_of_a_poisson_mean_are_those_of_the_tables(events, bound):
    # Garwood's table: upper limits of a one-sided 95 % interval.
    assert rate_bound(events, 1.0) == pytest.approx(bound, abs=0.005)


@pytest.mark.parametrize("events", [0, 1, 7])
def test_the_bound_is_the_rate_at_which_so_few_events_have_five_per_cent(events):
    mean = rate_bound(events, 1.0)
    chance = sum(math.exp(-mean) * mean**k / math.factorial(k) for k in range(events + 1))
    assert chance == pytest.approx(0.05, rel=1e-9)


def test_nothing_follows_from_no_time_and_no_trial():
    assert rate_bound(0, 0.0) == math.inf
    assert share_bound(0, 0) == 1.0


def test_the_bound_of_a_share():
    assert share_bound(0, 59) == pytest.approx(1.0 - 0.05 ** (1 / 59), rel=1e-9)
    assert share_bound(3, 3) == 1.0
    p = share_bound(2, 20)
    chance = sum(math.comb(20, k) * p**k * (1 - p) ** (20 - k) for k in range(3))
    assert chance == pytest.approx(0.05, rel=1e-9)


@given(st.lists(st.lists(st.floats(-1e3, 1e3), max_size=8), min_size=1, max_size=6))
def test_pooled_moments_are_those_of_all_samples(parts):
    together = np.concatenate([np.array(part, float) for part in parts])
    found = pooled(Moments.of(np.array(part)) for part in parts)
    assert found.count == len(together)
    if len(together):
        assert found.mean == pytest.approx(float(together.mean()), abs=1e-9)
        assert found.deviation == pytest.approx(float(together.std()), abs=1e-6)
    else:
        assert math.isnan(found.mean)
        assert math.isnan(found.deviation)


def test_moments_leave_out_what_is_missing():
    assert Moments.of(np.array([1.0, math.nan, 3.0])) == Moments(2, 2.0, 2.0)


def test_the_area_under_the_curve():
    assert area_under_curve([1, 2, 3], [4, 5]) == 1.0
    assert area_under_curve([4, 5], [1, 2, 3]) == 0.0
    assert area_under_curve([1, 2], [1, 2]) == 0.5
    assert area_under_curve([0.0, 1.0, math.nan], [1.0]) == 0.75
    assert math.isnan(area_under_curve([], [1.0]))


@given(st.lists(st.integers(0, 5), min_size=1, max_size=9), st.lists(st.integers(0, 5), min_size=1, max_size=9))
def test_the_area_is_the_share_of_pairs_in_order(lower, higher):
    pairs = [1.0 if high > low else 0.5 if high == low else 0.0 for low in lower for high in higher]
    assert area_under_curve(lower, higher) == pytest.approx(sum(pairs) / len(pairs))


def test_quantiles_keep_what_was_never_found():
    times = [4.0, 1.0, math.inf, 2.0]
    assert quantile(times, 0.5) == 2.0
    assert quantile(times, 0.75) == 4.0
    assert quantile(times, 0.95) == math.inf
    assert math.isnan(quantile([], 0.5))
    assert quantile(range(1, 101), 0.95) == 95.0


def test_five_pairs_of_one_sign():
    found = paired([1.0, 2.0, 3.0, 4.0, 5.0])
    assert found.sign_p == pytest.approx(2.0 * 0.5**5)
    assert found.rank_p == pytest.approx(2.0 / 2**5)
    assert (found.count, found.positive, found.negative) == (5, 5, 0)
    assert found.mean == found.median == 3.0
    assert 1.0 < found.interval[0] < 3.0 < found.interval[1] < 5.0


def test_pairs_that_do_not_differ_and_pairs_that_do_not_exist():
    same = paired([0.0, 0.0, math.nan])
    assert same.count == 2
    assert math.isnan(same.sign_p)
    assert math.isnan(same.rank_p)
    assert same.interval == (0.0, 0.0)
    assert paired([]).count == 0


def test_the_bootstrap_interval_is_that_of_the_normal_distribution_for_many_pairs():
    values = np.random.default_rng(1).normal(0.5, 2.0, 400)
    low, high = paired(values).interval
    half = 1.96 * values.std() / math.sqrt(400)
    assert low == pytest.approx(values.mean() - half, abs=0.15 * half)
    assert high == pytest.approx(values.mean() + half, abs=0.15 * half)
    assert paired(values).interval == (low, high)
