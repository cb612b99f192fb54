import numpy as np
import pytest
from scipy.signal import lfilter

from tierod.detectors.design import run_length
from tierod.errors import InputError
from tierod.graph import scan
from tierod.monitors.driver_torque.hands import OFF, HandsMonitor
from tierod.monitors.driver_torque.hands_design import HeldRecord, design_thresholds, threshold_from_ratios
from tierod.vehicles import load


def ratios(count, shift, seed=1):
    """Log-likelihood ratios of N(shift, 1) against N(0, 1) for white samples of the latter."""
    return shift * np.random.default_rng(seed).standard_normal(count) - 0.5 * shift * shift


def test_for_white_ratios_it_meets_the_closed_form():
    shift = 0.5
    design = threshold_from_ratios([ratios(400_000, shift)], 1e5)
    # A sum of these ratios is Page's with drift shift/2 in standard deviations, its threshold in nats over the shift.
    assert run_length(0.5 * shift, design.threshold / shift, sides="upper") == pytest.approx(1e5, rel=0.5)
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
    with pytest.raises(InputError, match="not against"):
        threshold_from_ratios([np.full(2000, 0.9)], 1e4)


def test_a_monitor_is_designed_for_both_changes():
    draw, time = np.random.default_rng(4), np.arange(0.0, 60.0, 1e-3)
    held = (np.floor(time / 5.0) % 2.0).astype(float)
    noise = draw.standard_normal((3, len(time)))
    hand = held * 0.15 * np.convolve(noise[0], np.hanning(150) / 7.5, "same")
    rate = lfilter([0.0, 1e-3 / 0.035], [1.0, -np.exp(-1e-3 * 0.2286 / 0.035)], hand)
    samples = np.column_stack([np.cumsum(rate) * 1e-3 + 1e-4 * noise[1], 0.01 * noise[2]])
    monitor = HandsMonitor.of_vehicle(load("column-bench"), 1e-3)
    design = design_thresholds(monitor, [HeldRecord(samples, held)], 0.1)
    assert all(each > 0.0 for each in design.thresholds)
    assert np.any(scan(monitor, samples)["hands"] == OFF)
