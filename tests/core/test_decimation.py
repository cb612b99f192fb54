from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from report_pages import unpack
from tierod.core.decimation import MEMORY, Decimator, bins_each, coarser, merged, outline, pack
from tierod.core.findings import Trace


@given(st.lists(st.integers(1, 400), min_size=1, max_size=12), st.integers(2, 60))
def test_nothing_is_hidden_however_the_recording_is_cut(cuts, bins):
    count = sum(cuts)
    values = np.random.default_rng(count).normal(size=count)
    values[::7] = np.nan
    time = 5.0 + 0.01 * np.arange(count)
    pieces, whole = Decimator("signal", "N*m", bins), Decimator("signal", "N*m", bins)
    for stop, length in zip(np.cumsum(cuts), cuts, strict=True):
        pieces.add(time[stop - length : stop], values[stop - length : stop])
    whole.add(time, values)
    trace = whole.trace()
    assert len(trace.time) <= 2 * bins
    if np.isfinite(values).any():
        assert np.nanmin(trace.lower) == np.nanmin(values)
        assert np.nanmax(trace.upper) == np.nanmax(values)
    if cuts[0] > 1:
        np.testing.assert_allclose(pieces.trace().mean, trace.mean, rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(pieces.trace().lower, trace.lower)


@pytest.mark.parametrize("each", [1, 2, 3, 8, 16, 40])
@pytest.mark.parametrize("offset", [0, 1, 5])
def test_bins_with_equally_many_samples_hold_the_same_as_sample_by_sample(each, offset):
    count = 50 * each + offset
    time, values = np.arange(count) / each, np.random.default_rng(each).normal(size=count)
    decimator = Decimator("signal", "", bins=100)
    decimator.add(np.array([0.0, 1.0]), np.array([0.0, 0.0]))  # bins of one second
    decimator.add(1.0 + time, values)
    trace = decimator.trace()
    for at in range(1, len(trace.time)):
        inside = values[np.floor(1.0 + time + 1e-6) == at].tolist() + [0.0] * (at == 1)
        assert (trace.lower[at], trace.upper[at]) == (min(inside), max(inside))
        total = 0.0
        for value in inside[-1:] * (at == 1) + inside[: len(inside) - (at == 1)]:
            total += value
        assert trace.mean[at] == total / len(inside)


def test_bins_hold_their_own_samples():
    decimator = Decimator("signal", "", bins=2)
    decimator.add(np.arange(8.0), np.array([1.0, 3.0, 2.0, 2.0, np.nan, np.nan, 5.0, 7.0]))
    trace = decimator.trace()
    np.testing.assert_array_equal(trace.time, [0.0, 2.0, 4.0, 6.0])
    np.testing.assert_array_equal(trace.lower, [1.0, 2.0, np.nan, 5.0])
    np.testing.assert_array_equal(trace.upper, [3.0, 2.0, np.nan, 7.0])
    assert trace.mean[3] == pytest.approx(6.0)


def test_an_empty_decimator_gives_an_empty_trace():
    decimator = Decimator("signal", "")
    decimator.add(np.empty(0), np.empty(0))
    assert len(decimator.trace().time) == 0


def test_time_that_stands_still_at_first_does_no_harm():
    decimator = Decimator("a", "m", 4)
    decimator.add(np.array([1.0, 1.0, 1.0, 2.0]), np.array([3.0, 1.0, 2.0, 5.0]))
    trace = decimator.trace()
    np.testing.assert_array_equal(trace.lower, [1.0, 5.0])
    np.testing.assert_array_equal(trace.mean, [2.0, 5.0])


@pytest.mark.parametrize("traces", [0, 1, 14, 30, 100, 1000, 10**7])
def test_all_traces_of_a_recording_share_the_memory(traces):
    bins = bins_each(traces)
    assert bins >= 1
    assert bins & (bins - 1) == 0
    assert 2 * bins * max(traces, 1) <= MEMORY or bins == 1


def made(count, seed=0, scale=1.0, offset=0.0):
    rng = np.random.default_rng(seed)
    mean = scale * rng.normal(size=count).cumsum() + offset
    mean[rng.random(count) < 0.1] = np.nan
    return Trace("a", "m", 3.0 + 0.25 * np.arange(count), mean - scale * rng.random(count), mean + scale, mean)


@pytest.mark.parametrize("count", [0, 1, 2, 1000])
@pytest.mark.parametrize("bits", [2, 12, 16])
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-9, 7.0), (1e300, 0.0), (0.0, 4.0), (1e-320, 0.0)])
def test_what_is_packed_comes_back_but_for_the_rounding(count, bits, scale, offset):
    whole = made(count, scale=scale, offset=offset)
    again = unpack(pack(whole, bits))
    assert (again.name, again.unit) == ("a", "m")
    np.testing.assert_allclose(again.time, whole.time, rtol=1e-12)
    for part in ("lower", "mean", "upper"):
        one, other = getattr(again, part), getattr(whole, part)
        np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))
        if np.isfinite(other).any():
            most = max(np.nanmax(np.abs(whole.upper)), np.nanmax(np.abs(whole.lower)))
            spread = np.nanmax(whole.upper / 2) - np.nanmin(whole.lower / 2)
            room = 1.01 * spread / (2**bits - 2) + 1e-11 * most + 1e-318
            assert np.nanmax(np.abs(one - other)) <= room
    assert not np.any(again.lower > again.mean)
    assert not np.any(again.mean > again.upper)


def test_a_trace_whose_bins_differ_in_width_is_not_packed():
    time = np.array([0.0, 1.0, 3.0])
    assert pack(Trace("a", "", time, time, time, time)) is None


@given(st.integers(0, 300), st.integers(1, 40))
def test_a_coarser_level_hides_nothing(count, step):
    whole = made(count)
    level = coarser(whole, step)
    assert len(level.time) == -(-count // step)
    for place in range(len(level.time)):
        part = slice(place * step, (place + 1) * step)
        if np.isfinite(whole.mean[part]).any():
            assert level.lower[place] == np.nanmin(whole.lower[part])
            assert level.upper[place] == np.nanmax(whole.upper[part])
            assert level.mean[place] == pytest.approx(np.nanmean(whole.mean[part]))
        else:
            assert np.isnan(level.mean[place])


def test_merging_leaves_no_more_points_than_asked_for():
    assert len(merged(made(1001), 100).time) <= 100
    whole = made(100)
    assert merged(whole, 100) is whole


@given(st.integers(0, 2000), st.integers(10, 300), st.integers(0, 40))
def test_an_outline_keeps_peaks_ends_and_gaps(count, most, gaps):
    chance = np.random.default_rng(count)
    values = chance.normal(size=count)
    for start in chance.integers(0, max(count, 1), gaps):
        values[start : start + 5] = chance.choice([np.nan, np.inf])
    kept = outline(values, most)
    finite = np.where(np.isfinite(values), values, np.nan)
    assert np.all(np.diff(kept) > 0)
    if count <= most:
        assert len(kept) == count
        return
    assert len(kept) <= most + gaps
    assert {0, count - 1} <= set(kept.tolist())
    if np.isfinite(finite).any():
        assert np.nanmin(finite[kept]) == np.nanmin(finite)
        assert np.nanmax(finite[kept]) == np.nanmax(finite)
    # No line is drawn over a gap: between two kept samples on its sides one of it is kept.
    for before, after in pairwise(kept):
        if np.isfinite(finite[before]) and np.isfinite(finite[after]):
            assert np.isfinite(finite[before : after + 1]).all()


def test_a_single_peak_of_every_bin_is_kept():
    values = np.zeros(10_000)
    values[123::250] = 5.0
    values[200::250] = -3.0
    kept = outline(values, 1600)
    assert np.count_nonzero(values[kept] == 5.0) == 40
    assert np.count_nonzero(values[kept] == -3.0) == 40


@pytest.mark.parametrize("missing", [0.0, 0.3])
def test_every_bin_is_what_its_samples_say(missing):
    chance = np.random.default_rng(4)
    time = np.cumsum(chance.choice([0.01, 0.02, 0.4], 5000, p=[0.8, 0.15, 0.05]))
    first, second = np.where(chance.random((2, 5000)) < missing, np.nan, chance.normal(size=(2, 5000)))
    one, other = Decimator("one", "", bins=64), Decimator("other", "", bins=64)
    for part in np.split(np.arange(5000), [700, 701, 2400]):
        other.add(time[part], second[part], one.add(time[part], first[part]))
    for decimator, values in ((one, first), (other, second)):
        trace = decimator.trace()
        width = trace.time[1] - trace.time[0]
        bins = np.floor((time - time[0]) / width + 1e-6).astype(int)
        for at in range(len(trace.time)):
            inside = values[(bins == at) & np.isfinite(values)]
            found = trace.lower[at], trace.mean[at], trace.upper[at]
            expected = (inside.min(), inside.mean(), inside.max()) if len(inside) else (np.nan,) * 3
            assert found == pytest.approx(expected, rel=1e-12, nan_ok=True)


def test_places_of_other_bins_are_not_taken_over():
    time = np.arange(100) * 0.1
    coarse, fine = Decimator("coarse", "", bins=8), Decimator("fine", "", bins=200)
    fine.add(time, time, coarse.add(time, time))
    np.testing.assert_array_equal(fine.trace().mean, time)
