"""Friction at the motor, its level unknown."""

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters
from tierod.vehicles import load
from tierod_lab.papers.column.column_friction import ColumnFrictionObserver, FrictionTuning

BENCH = load("column-bench")
KNOWN = BENCH.parameters_for(ColumnParameters)


@pytest.mark.parametrize("level", [0.05, 0.1, 0.15])
def test_friction_and_level_are_found(level):
    measured, true = run("ramps")
    found = scan(ColumnFrictionObserver.of_parameters(KNOWN, 0.05, friction=FrictionTuning(level=level)), measured)
    used = true["time"] > 1.0
    assert rms((found["disturbance_torque"] - true["disturbance_torque"])[used]) < 0.004
    assert found["friction_level"][20_000] == pytest.approx(0.1, rel=0.03)
    assert abs(found["friction_level"][-1] - 0.1) < 3.0 * found["friction_level_deviation"][-1]


def test_the_torque_is_surer_than_a_level_that_is_not_known_yet():
    measured, true = run("ramps")
    found = scan(ColumnFrictionObserver.of_parameters(KNOWN, 0.05), measured)
    early = (true["time"] > 0.2) & (true["time"] < 2.0)
    error, said = (found["disturbance_torque"] - true["disturbance_torque"])[early], "disturbance_torque_deviation"
    assert rms(error) < rms(found[said][early]) < 4.0 * rms(error)


def test_a_wrong_angle_still_beats_a_walk():
    measured, true = run("ramps")
    found = scan(ColumnFrictionObserver.of_parameters(KNOWN, 0.1), measured)
    used = true["time"] > 1.0
    assert rms((found["disturbance_torque"] - true["disturbance_torque"])[used]) < 0.01


def test_the_level_survives_a_gap():
    measured, _ = run("ramps")
    broken = measured[:20_000].copy()
    broken[15_000:15_200] = np.nan
    found = scan(ColumnFrictionObserver.of_vehicle(BENCH), broken)
    assert np.isfinite(found.values).all()
    assert found["friction_level"][15_200] == pytest.approx(found["friction_level"][14_999], rel=0.1)


def test_refused():
    with pytest.raises(ParameterError, match="dahl_angle is 0.0"):
        ColumnFrictionObserver.of_parameters(KNOWN, 0.0)
    with pytest.raises(ParameterError, match="motor_friction"):
        ColumnFrictionObserver.of_vehicle(load("midsize-eps"))
