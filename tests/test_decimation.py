import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.decimation import Decimator


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
