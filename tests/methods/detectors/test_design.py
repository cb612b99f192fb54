import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.methods.detectors import Cusum
from tierod.methods.detectors.design import run_length, threshold_for


def simulated(drift, threshold, sides, change, count=2_000_000, seed=0):
    block = Cusum(drift, threshold, threshold, sides=sides, restart=True)
    alarms = scan(block, np.random.default_rng(seed).normal(size=count) + change)["alarm"]
    return count / alarms.sum()


@pytest.mark.parametrize(
    ("drift", "threshold", "sides", "change"),
    [
        (0.5, 4.0, "upper", 0.0),
        (0.5, 4.0, "lower", 0.0),
        (0.5, 4.0, "both", 0.0),
        (0.25, 6.0, "upper", 0.0),
        (0.5, 5.0, "upper", 1.0),
        (0.5, 5.0, "upper", 0.5),
        (0.25, 8.0, "both", -0.75),
    ],
)
def test_run_length_is_that_of_a_simulation(drift, threshold, sides, change):
    expected = run_length(drift, threshold, change, sides)
    assert simulated(drift, threshold, sides, change) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(
    ("threshold", "change", "samples"), [(4.0, 0.0, 168.0), (5.0, 0.0, 465.0), (4.0, 0.5, 26.6), (5.0, 1.0, 10.4)]
)
def test_values_of_the_literature(threshold, change, samples):
    """D. C. Montgomery, Introduction to Statistical Quality Control, two-sided table for k = 0.5."""
    assert run_length(0.5, threshold, change) == pytest.approx(samples, rel=0.02)


@pytest.mark.parametrize("sides", ["both", "upper"])
@pytest.mark.parametrize("samples", [100.0, 1e4, 1e9])
@pytest.mark.parametrize("drift", [0.0, 0.25, 1.0])
def test_threshold_is_the_inverse(drift, samples, sides):
    threshold = threshold_for(drift, samples, sides)
    assert run_length(drift, threshold, sides=sides) == pytest.approx(samples, rel=1e-6)


def test_the_designed_threshold_keeps_its_promise():
    threshold = threshold_for(0.5, 2000.0)
    assert simulated(0.5, threshold, "both", 0.0) == pytest.approx(2000.0, rel=0.1)


def test_huge_thresholds_do_not_overflow():
    assert run_length(1.0, 1e6) == math.inf


@pytest.mark.parametrize(
    "call",
    [
        lambda: threshold_for(0.5, 0.5),
        lambda: threshold_for(0.5, math.inf),
        lambda: run_length(-1.0, 5.0),
        lambda: run_length(0.5, 5.0, sides="up"),
    ],
)
def test_wrong_requests_are_refused(call):
    with pytest.raises(ParameterError):
        call()
