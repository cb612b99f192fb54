"""How coarse a sensor is shows in the smallest step between two readings."""

import math

import numpy as np
import pytest

from tierod.monitors.condition.rolling_filter import SmallestSteps

RESIDUE = 1e-6


def after(readings, coarsest=0.5):
    steps = SmallestSteps.unseen((coarsest,))
    for each in readings:
        steps = steps.after((each,), (RESIDUE,))
    return steps.smallest[0]


def test_rounded_readings_show_their_step_and_its_variance():
    fine = np.random.default_rng(1).normal(0.0, 0.3, 500).cumsum()
    step = 0.0223
    rounded = step * np.round(fine / step)
    assert after(rounded.tolist()) == pytest.approx(step)
    steps = SmallestSteps.unseen((0.5,)).after((step,), (RESIDUE,))
    # The variance of the rounding error itself, over many readings.
    assert steps.variances[0] == pytest.approx(np.var(rounded - fine), rel=0.2)


def test_a_rounding_residue_is_no_step():
    assert after([0.0, 0.2, 0.2 + 1e-13, 0.4, 0.2]) == pytest.approx(0.2)


def test_readings_that_repeat_or_are_missing_show_nothing():
    assert after([0.2, 0.2, math.nan, 0.2]) == pytest.approx(0.2)
    assert after([0.0, 0.0, math.nan]) == 0.5
