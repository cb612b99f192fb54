import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.methods.detectors.random_walk import Walk, run_length
from tierod_lab.papers.column.measured_ratios import threshold_from_ratios


def ratios(count, shift, seed=1):
    """Log-likelihood ratios of N(shift, 1) against N(0, 1) for white samples of the latter."""
    return shift * np.random.default_rng(seed).standard_normal(count) - 0.5 * shift * shift


def test_for_white_ratios_it_meets_the_closed_form():
    shift = 0.5
    design = threshold_from_ratios([ratios(400_000, shift)], 1e5)
    # A sum of these ratios is Page's with drift shift/2 in standard deviations, its threshold in nats over the shift.
    assert run_length(Walk(0.0, design.threshold / shift, True, 1.0, -0.5 * shift, 1.0)) == pytest.approx(1e5, rel=0.5)
    assert design.growth == pytest.approx(1.0, rel=0.15)


def test_what_is_missing_is_not_counted():
    whole = ratios(200_000, 0.5)
    holed = whole.copy()
    holed[::2] = np.nan
    once, twice = (threshold_from_ratios([each], 1e4).points[3].run_length for each in (whole, holed))
    assert once == pytest.approx(twice, rel=0.3)


def test_too_few_alarms_are_refused():
    with pytest.raises(InputError, match="too few false alarms"):
        threshold_from_ratios([-np.ones(1000)], 1e4)


def test_evidence_that_grows_is_refused():
    with pytest.raises(InputError, match="do not decrease"):
        threshold_from_ratios([np.full(2000, 0.9)], 1e4)


def test_a_line_that_falls_is_refused():
    # Alarms come of single values far above every threshold of the ladder: each finds as many.
    record = np.full(20_000, -0.01)
    record[::1000] = 100.0
    record -= np.mean(record) + 0.01
    with pytest.raises(InputError, match="does not grow"):
        threshold_from_ratios([record], 1e6)
