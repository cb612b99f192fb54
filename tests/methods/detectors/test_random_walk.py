import math

import pytest

from tierod.core.errors import ParameterError
from tierod.methods.detectors.random_walk import Walk, run_length


def siegmund(drift, threshold):
    """Closed approximation of the run length of a CUSUM (Siegmund, Sequential Analysis, 1985)."""
    exponent = 2.0 * drift * (threshold + 1.166)
    return (math.exp(exponent) - exponent - 1.0) / (2.0 * drift**2)


@pytest.mark.parametrize(("threshold", "samples"), [(4.0, 335.37), (5.0, 930.89)])
def test_cusum_of_the_literature(threshold, samples):
    assert run_length(Walk(0.0, threshold, True, 1.0, -0.5, 1.0)) == pytest.approx(samples, abs=0.01)


@pytest.mark.parametrize(
    ("weight", "width", "change", "samples"),
    [(0.1, 2.814, 0.0, 500.0), (0.1, 2.814, 1.0, 10.3), (0.25, 2.998, 0.0, 500.0), (0.4, 3.054, 0.5, 71.2)],
)
def test_geometric_average_of_the_literature(weight, width, change, samples):
    height = width * math.sqrt(weight / (2.0 - weight))
    walk = Walk(-height, height, False, 1.0 - weight, weight * change, weight)
    assert run_length(walk) == pytest.approx(samples, rel=0.005)


@pytest.mark.parametrize(
    ("walk", "samples", "digits"),
    [
        (Walk(0.0, 24.0, True, 1.0, -0.5, 1.0), 1.687125753e11, 1e-8),
        (Walk(-4.5, 22.0, True, 1.0, -4.5, 3.0), 3.170139159e10, 1e-8),
        (Walk(-1.5, 1.5, False, 0.9, 0.0, 0.1), 1.862034948e10, 1e-5),
    ],
    ids=["cusum", "sequential", "average"],
)
def test_long_walks_keep_their_digits(walk, samples, digits):
    assert run_length(walk) == pytest.approx(samples, rel=digits)


def test_wide_walks_meet_siegmund():
    assert run_length(Walk(0.0, 700.0, True, 1.0, -0.01, 1.0)) == pytest.approx(siegmund(0.01, 700.0), rel=1e-4)
    assert run_length(Walk(0.0, 2000.0, True, 1.0, -0.002, 1.0)) == pytest.approx(siegmund(0.002, 2000.0), rel=1e-4)


def test_a_walk_that_never_ends_is_infinite():
    assert run_length(Walk(0.0, 30.0, True, 1.0, -3.0, 1.0)) == math.inf
    assert run_length(Walk(-2.0, 2.0, False, 0.9, 0.0, 0.1)) == math.inf


def test_a_start_near_the_limit_ends_sooner():
    walk = Walk(0.0, 5.0, True, 1.0, -0.5, 1.0)
    lengths = [run_length(walk, start) for start in (0.0, 2.5, 5.0)]
    assert lengths == sorted(lengths, reverse=True)


def test_a_walk_without_drift_between_two_ends_takes_the_square_of_the_distance():
    length = run_length(Walk(-20.0, 20.0, False, 1.0, 0.0, 1.0))
    assert length == pytest.approx((20.0 + 0.583) ** 2, rel=1e-3)  # Wald, with Siegmund's overshoot


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"deviation": 0.0}, "between the limits"),
        ({"upper": -1.0}, "between the limits"),
        ({"upper": 1e9}, "look for a larger shift"),
    ],
)
def test_walks_that_cannot_be_are_refused(change, says):
    walk = Walk(**{"lower": 0.0, "upper": 5.0, "restart": True, "factor": 1.0, "mean": 0.0, "deviation": 1.0, **change})
    with pytest.raises(ParameterError, match=says):
        run_length(walk)
