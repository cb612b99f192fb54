"""The default observer of a column: exactness, gaps, cars without gear or motor angle, parameters that do not fit."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.observer import UNKNOWN, ColumnObserver
from tierod.vehicles import load

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

BENCH = load("column-bench")
KNOWN = BENCH.parameters_for(ColumnParameters)


@pytest.fixture(scope="module")
def observer():
    return ColumnObserver.of_vehicle(BENCH)


@pytest.mark.parametrize(("hands", "goal"), [("steps", 0.07), ("ramps", 0.04), ("free", 0.04)])
def test_torque_of_the_hands_within_its_goal(observer, hands, goal):
    measured, true = run(hands)
    found = scan(observer, measured)
    used = true["time"] > 0.5
    assert rms((found["hand_torque"] - true["hand_torque"])[used]) < goal
    assert rms((found["disturbance_torque"] - true["disturbance_torque"])[used]) < 0.018
    assert rms((found["steering_wheel_rate"] - true["steering_wheel_rate"])[used]) < 0.02
    assert found["nis"][used].mean() == pytest.approx(3.0, rel=0.05)
    np.testing.assert_array_equal(found["ready"][true["time"] > 0.2], 1.0)


def test_gaps_hold_and_start_again_and_never_are_nan(observer):
    measured, true = run("ramps")
    broken = measured[:12_000].copy()
    broken[:30] = np.nan
    broken[5_000:5_020] = np.nan  # shorter than the longest gap
    broken[8_000:8_400] = np.nan  # longer
    broken[9_000:9_500:7, 1] = np.nan
    found = scan(observer, broken)
    assert np.isfinite(found["hand_torque"]).all()
    deviation = found["hand_torque_deviation"]
    assert deviation[10] >= UNKNOWN
    assert np.all(np.diff(deviation[5_000:5_020]) > 0.0)
    assert found["ready"][5_010] == 1.0
    assert np.all(np.diff(deviation[8_100:8_390]) > 0.0)
    assert found["hand_torque"][8_100] == found["hand_torque"][8_390]
    assert not found["ready"][8_060:8_450].any()
    after = slice(8_550, 9_000)
    assert rms(found["hand_torque"][after] - true["hand_torque"][:12_000][after]) < 0.1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"steering_wheel_inertia": -0.035}, "steering_wheel_inertia of the column is -0.035"),
        ({"motor_damping": -0.01}, "unstable: eigenvalue"),
        ({"steering_wheel_damping": -2.0}, "unstable: eigenvalue .* 1/s in .*steering_wheel_rate"),
        ({"gear_inertia": 1e-7}, "too fast for its rate: eigenvalue"),
        ({"torsion_bar_stiffness": 0.0}, "torsion_bar_stiffness of the column is 0"),
    ],
)
def test_parameters_that_do_not_fit_are_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        ColumnObserver.of_parameters(replace(KNOWN, **change))
