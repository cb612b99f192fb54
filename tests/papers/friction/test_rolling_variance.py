from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod_lab.papers.friction.variance_method import RollingVariance


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3), st.floats(0.0, 1.0))
def test_is_the_variance_of_the_counted_samples_of_whole_blocks(seed, offset, share):
    random = np.random.default_rng(seed)
    block = RollingVariance(block_samples=7, blocks=3)
    values = random.standard_normal(100) + offset
    counted = (random.random(100) < share).astype(float)
    run = scan(block, np.column_stack([values, counted]))
    for end in range(100):
        stop = (end + 1) // 7 * 7
        window = slice(max(stop - 21, 0), stop)
        kept = values[window][counted[window] > 0.0]
        assert run["samples"][end] == len(kept)
        expected = np.var(kept, ddof=1) if len(kept) >= 2 else 0.0
        assert run["variance"][end] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_missing_samples_never_count():
    run = scan(RollingVariance(5, 2), [[np.nan, 1.0]] * 10 + [[1.0, np.nan]] * 10)
    assert np.all(run["samples"] == 0.0)
    assert np.all(np.isfinite(run.state.values))


def test_does_not_drift_over_a_million_samples():
    values = np.random.default_rng(1).standard_normal(1_000_000) + 1e6
    run = scan(RollingVariance(100, 15), np.column_stack([values, np.ones_like(values)]))
    assert run["variance"][-1] == pytest.approx(np.var(values[-1500:], ddof=1), rel=1e-5)


@pytest.mark.parametrize("size", [(0, 15), (100, 0)])
def test_an_empty_window_is_refused(size):
    with pytest.raises(ParameterError, match="at least 1 of each"):
        RollingVariance(*size)
