"""Noises that a filter adapts to what its model lacks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.monitors.sideslip.tuning import NoiseScale, ScaleState

STEP = 0.01


def after(innovations, variance=1.0, block=None, running=1.0):
    block = block or NoiseScale(STEP)
    state = block.init()
    for each in innovations:
        state = block.after(state, each, variance, running)
    return block.scale(state)


def test_white_innovations_of_a_filter_that_is_not_sure_leave_the_noise():
    rng = np.random.default_rng(3)
    assert after(rng.normal(0.0, 0.4, 6000)) < 1.3


def test_errors_that_last_raise_it_and_white_ones_let_it_fall():
    rng = np.random.default_rng(3)
    lasting = np.repeat(rng.normal(0.0, 1.0, 60), 50)
    raised = after(lasting)
    assert raised > 30.0
    assert after([*lasting, *rng.normal(0.0, 0.3, 4000)]) < 0.2 * raised


def test_it_settles_where_the_filter_expects_some_more_than_it_sees():
    """White noise of four times the variance: since the scale rises faster than it falls, it comes to 2.6 times it."""
    rng = np.random.default_rng(5)
    block, found = NoiseScale(STEP), []
    state = block.init()
    for each in rng.normal(0.0, 2.0, 60_000):
        state = block.after(state, each, block.scale(state), 1.0)
        found.append(block.scale(state))
    assert np.median(found[20_000:]) == pytest.approx(2.6 * 4.0, rel=0.4)


def test_a_single_leap_counts_little():
    rng = np.random.default_rng(3)
    quiet = rng.normal(0.0, 0.4, 500)
    assert after([*quiet, 1e6]) < 1.1 * max(after(quiet), 1.0)


def test_a_missing_reading_holds_it_and_none_is_below_one():
    block = NoiseScale(STEP, greatest=3.0)
    state = ScaleState(0.4, 1.2)
    assert block.after(state, math.nan, 1.0, 1.0) == state
    assert block.after(state, 3.0, 1.0, 0.0) == state
    assert after([0.0] * 5000) == 1.0
    assert after([50.0] * 5000, block=block) == pytest.approx(math.exp(3.0))
    assert after([50.0] * 5000, block=NoiseScale(STEP, greatest=0.0)) == 1.0
