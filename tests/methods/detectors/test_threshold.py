import dataclasses

import numpy as np
import pytest

from example_models import assert_floats_equal_scan
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors import Condition, Debounce

DEBOUNCE = Debounce(on_time=0.05, off_time=0.1, sample_time=0.01)


def test_debounce_agrees_with_counting():
    rng = np.random.default_rng(2)
    values = np.repeat(rng.integers(0, 2, 150), rng.integers(1, 20, 150)).astype(float)
    values[rng.random(len(values)) < 0.2] = np.nan
    result = assert_floats_equal_scan(DEBOUNCE, values)
    active, run, expected = 0, 0, []
    for value in values:
        if np.isfinite(value):
            run = run + 1 if value != active else 0
            if run == (10 if active else 5):
                active, run = 1 - active, 0
        expected.append(active)
    np.testing.assert_array_equal(result["active"], expected)
    assert 0.1 < np.mean(expected) < 0.9
    assert ((result["progress"] >= 0.0) & (result["progress"] <= 1.0)).all()


def test_debounce_at_once_and_disabled():
    block = Debounce(0.0, 0.0, 0.01)
    np.testing.assert_array_equal(scan(block, [0.0, 1.0, 1.0, 0.0])["active"], [0, 1, 1, 0])
    assert block.step(block.init(), Condition(1.0), enabled=0.0)[1].active == 0.0


def test_false_alarms_of_debounce_are_as_far_apart_as_documented():
    rng = np.random.default_rng(0)
    p, n = 0.3, 3
    block = Debounce(n * 0.01, 0.0, 0.01)
    active = scan(block, (rng.random(400_000) < p).astype(float))["active"]
    starts = np.flatnonzero(np.diff(active, prepend=0.0) > 0.5)
    ends = np.flatnonzero(np.diff(active, prepend=0.0) < -0.5)
    waits = starts[1:] - ends[: len(starts) - 1]
    assert waits.mean() == pytest.approx((1.0 / p**n - 1.0) / (1.0 - p), rel=0.03)


@pytest.mark.parametrize(
    ("block", "changes", "words"),
    [
        (DEBOUNCE, {"on_time": -1.0}, "on_time is -1.0"),
        (DEBOUNCE, {"sample_time": 0.0}, "sample_time is 0.0"),
    ],
)
def test_wrong_tuning_is_refused(block, changes, words):
    with pytest.raises(ParameterError, match=words):
        dataclasses.replace(block, **changes)
