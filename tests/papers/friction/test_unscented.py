from __future__ import annotations

import numpy as np
import pytest

from models.friction_paper import CAR
from papers.friction.drives import driven, enabled_seconds
from tierod.core.graph import scan
from tierod_lab.papers.friction.presets import consistent, unscented


def level(monitor, drive) -> float:
    run = scan(monitor, drive)
    return float(np.mean(run["friction_torque"][enabled_seconds(run["enabled"]) > 50.0]))


@pytest.mark.parametrize("friction", [4.0, 12.5])
def test_gains_little_over_the_consistent_kalman_filter(friction):
    assert level(unscented(CAR), driven(friction)) == pytest.approx(level(consistent(CAR), driven(friction)), abs=0.3)


def test_a_wider_tanh_reads_higher():
    sharp, wide = (level(unscented(CAR, smoothing_rate=rate), driven(12.5)) for rate in (0.02, 0.05))
    assert 1.02 < wide / sharp < 1.10


def test_float_steps_and_the_kernel_agree():
    monitor, samples = unscented(CAR), driven(8.0).values[6000:6200, :6]
    run, state = scan(monitor, samples), monitor.init()
    for index, row in enumerate(samples):
        state, output = monitor.step(state, monitor.Sample(*map(float, row)))
        assert output.friction_torque == pytest.approx(run["friction_torque"][index], rel=1e-8)
