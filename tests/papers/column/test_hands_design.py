import numpy as np
from scipy.signal import lfilter

from tierod.core.graph import scan
from tierod.monitors.driver_torque.hands import OFF, HandsMonitor
from tierod.papers.column.hands_design import HeldRecord, design_thresholds
from tierod.vehicles import load


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
