"""Torque of the hands with a lag."""

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.monitors.driver_torque.observer import DelayedHandTorque
from tierod.vehicles import load

BENCH = load("column-bench")


@pytest.mark.parametrize(("hands", "goal"), [("steps", 0.04), ("ramps", 0.015)])
def test_within_its_goal(hands, goal):
    measured, true = run(hands)
    found = scan(DelayedHandTorque.of_vehicle(BENCH), measured)
    error = found["hand_torque"][20:] - true["hand_torque"][:-20]
    assert rms(error[500:]) < goal
    if hands == "ramps":
        assert found["hand_torque_deviation"][-1] == pytest.approx(rms(error[500:]), rel=0.3)


def test_a_gap_holds_and_grows():
    measured, _ = run("ramps")
    broken = measured[:4_000].copy()
    broken[3_000:3_300] = np.nan
    found = scan(DelayedHandTorque.of_vehicle(BENCH), broken)
    assert np.isfinite(found.values).all()
    assert found["hand_torque"][3_100] == found["hand_torque"][3_290]
    assert found["hand_torque_deviation"][3_290] > found["hand_torque_deviation"][3_100]
    assert not found["ready"][3_060:3_350].any()


def test_a_delay_shorter_than_a_sample_is_refused():
    with pytest.raises(ParameterError, match="at least a sample"):
        DelayedHandTorque.of_vehicle(BENCH, 1e-3, delay=5e-4)
