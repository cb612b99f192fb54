import dataclasses

import numpy as np
import pytest

from example_models import assert_floats_equal_scan, with_gaps
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors import Cusum

BLOCK = Cusum(drift=0.5, threshold=3.0, ceiling=6.0)


def page(values, drift, threshold, ceiling, sides, restart):
    up = down = 0.0
    rows = []
    for value in values:
        if np.isfinite(value):
            if sides != "lower":
                up = min(max(0.0, up + value - drift), ceiling)
            if sides != "upper":
                down = min(max(0.0, down - value - drift), ceiling)
        alarm = up >= threshold or down >= threshold
        rows.append([up, down, float(alarm)])
        if restart and alarm:
            up = down = 0.0
    return np.array(rows)


@pytest.mark.parametrize("restart", [False, True])
@pytest.mark.parametrize("sides", ["both", "upper", "lower"])
def test_agrees_with_page(sides, restart):
    rng = np.random.default_rng(0)
    values = with_gaps(rng, rng.normal(size=500) + np.repeat([0.0, 1.0, -1.0, 0.0, 2.0], 100))
    block = dataclasses.replace(BLOCK, sides=sides, restart=restart)
    result = assert_floats_equal_scan(block, values)
    np.testing.assert_allclose(result.values, page(values, 0.5, 3.0, 6.0, sides, restart), atol=1e-12)
    assert 0.0 < result["alarm"].mean() < 1.0


def test_the_ceiling_bounds_the_recovery():
    values = np.concatenate([np.full(1000, 5.0), np.zeros(20)])
    alarm = scan(BLOCK, values)["alarm"]
    assert alarm[999] == 1.0
    assert alarm[1000:].sum() <= BLOCK.ceiling / BLOCK.drift
    assert alarm[-1] == 0.0


def test_a_ceiling_at_the_threshold_still_alarms():
    block = dataclasses.replace(BLOCK, ceiling=3.0)
    assert scan(block, np.ones(50))["alarm"][-1] == 1.0


def test_a_disabled_value_leaves_the_sums_and_bare_numbers_are_values():
    state, _ = BLOCK.step(BLOCK.init(), 2.0)
    assert state == BLOCK.step(BLOCK.init(), BLOCK.Sample(2.0))[0]
    assert BLOCK.step(state, 9.0, enabled=0.0)[0] == state
    assert BLOCK.step(state, 9.0, enabled=1.0) == BLOCK.step(state, 9.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sides": "up"}, "expected both, upper, lower"),
        ({"threshold": 0.0}, "threshold is 0.0"),
        ({"drift": -0.1}, "drift is -0.1"),
        ({"ceiling": 1.0}, "at least the threshold"),
    ],
)
def test_wrong_tuning_is_refused(changes, words):
    with pytest.raises(ParameterError, match=words):
        dataclasses.replace(BLOCK, **changes)
