"""The default observer of a column: exactness, gaps, cars without gear or motor angle, parameters that do not fit."""

from dataclasses import replace

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import rms, run
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.models.steering_column import ColumnParameters, without_gear
from tierod.monitors.driver_torque.design import ROAD, ColumnTuning, column_of_vehicle, usual_tuning
from tierod.monitors.driver_torque.observer import UNKNOWN, ColumnObserver, ColumnSample
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


def test_the_deviation_is_that_of_the_error(observer):
    measured, true = run("free")
    found = scan(observer, measured)
    used = true["time"] > 0.5
    error = (found["hand_torque"] - true["hand_torque"])[used]
    assert np.mean(np.abs(error) < 2.0 * found["hand_torque_deviation"][used]) > 0.95


def test_the_column_without_its_gear_does_as_well():
    measured, true = run("ramps")
    found = scan(ColumnObserver.of_parameters(without_gear(KNOWN)), measured)
    used = true["time"] > 0.5
    assert rms((found["hand_torque"] - true["hand_torque"])[used]) < 0.04
    np.testing.assert_allclose(found["gear_angle"] * 18.0, found["motor_angle_mechanical"])


def test_without_the_motor_angle_it_is_coarser():
    measured, true = run("ramps")
    blind = measured.copy()
    blind[:, 2] = np.nan
    tuning = ColumnTuning(outputs=("steering_wheel_angle", "driver_torque"))
    found = scan(ColumnObserver.of_parameters(KNOWN, tuning=tuning), blind)
    used = true["time"] > 0.5
    assert rms((found["hand_torque"] - true["hand_torque"])[used]) < 0.07
    assert not found["innovation.motor_angle_mechanical"].any()


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
    ("offset", "unit"), [("driver_torque", 1.0), ("motor_angle_mechanical", 18.0 / KNOWN.torsion_bar_stiffness)]
)
def test_an_offset_is_learnt(offset, unit):
    measured, true = run("free")
    shifted = measured + np.array([0.0, 0.0, 0.0, 0.1]) if offset == "driver_torque" else measured.copy()
    if offset != "driver_torque":
        shifted[:, 2] += 0.1 * unit
    found = scan(ColumnObserver.of_parameters(KNOWN, tuning=ColumnTuning(offset=offset)), shifted)
    assert found["offset"][-1] == pytest.approx(0.1 * unit, abs=0.02 * unit)
    late = true["time"] > 20.0
    assert abs(np.mean(found["hand_torque"][late])) < 0.01


def test_a_car_without_gear_has_what_its_column_leaves():
    car = load("midsize-eps")
    column = column_of_vehicle(car)
    assert column.motor_inertia * 20.0**2 + column.steering_wheel_inertia == pytest.approx(0.10)
    assert column.motor_damping * 20.0**2 + column.steering_wheel_damping == pytest.approx(0.8)
    assert usual_tuning(car) is ROAD
    assert usual_tuning(BENCH) == ColumnTuning()
    state, estimate = ColumnObserver.of_vehicle(car).step(
        ColumnObserver.of_vehicle(car).init(), ColumnSample(0.1, 0.2, 4.3, 1.5)
    )
    assert estimate.hand_torque == pytest.approx(1.5)
    assert estimate.disturbance_torque == pytest.approx(0.1 + 1.5 / 20.0)
    assert state.start.started == 1.0


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


def test_other_parameters_and_times_are_refused():
    with pytest.raises(ParameterError, match="expected ColumnParameters"):
        ColumnObserver.of_parameters(object())
    with pytest.raises(ParameterError, match="cannot be observed through driver_torque: .*steering_wheel_angle"):
        ColumnObserver.of_parameters(KNOWN, tuning=ColumnTuning(outputs=("driver_torque",)))
    with pytest.raises(ParameterError, match="expected both above zero"):
        ColumnObserver.of_parameters(KNOWN, tuning=ColumnTuning(jump_time=0.0))
    with pytest.raises(ParameterError, match="steering_wheel_inertia"):
        ColumnObserver.of_vehicle(load("rav4"))
