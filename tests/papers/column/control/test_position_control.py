import math
from dataclasses import replace

import numpy as np
import pytest

from controlled_column import COLUMN, CONTROL, STEP, turn
from tierod.core.errors import ParameterError
from tierod.models.steering_column import without_gear
from tierod_lab.papers.column.control.lqr import column_system, regulator
from tierod_lab.papers.column.control.position_control import (
    ObservedColumn,
    PositionControl,
    TorqueLimits,
)
from tierod_lab.papers.column.control.reference import Reference, Step, Sweep

BELIEF = without_gear(COLUMN)


def tracking(result, source, time, after):
    error = np.degrees(result["gear_angle"] - source.at(time).angle)
    return float(np.sqrt((error[time > after] ** 2).mean()))


@pytest.mark.parametrize("frequency", [0.5, 3.0])
def test_the_shaft_follows_a_sine(frequency):
    source = Sweep(start=frequency, stop=frequency)
    time, result = turn(source, 6.0)
    assert tracking(result, source, time, 3.0) < 0.05
    time, plain = turn(source, 6.0, feed_forward=0.0)
    assert tracking(plain, source, time, 3.0) > 10.0 * tracking(result, source, time, 3.0)


def test_the_integral_takes_up_a_constant_torque():
    time, result = turn(Step(0.3), 4.0, disturbance=0.2)
    assert abs(result["gear_angle"][-1] - 0.3) < 1e-4
    assert result["control.motor_torque"][-1] == pytest.approx(0.2, abs=1e-3)
    assert np.abs(result["gear_angle"][time < 0.5]).max() > 0.01


@pytest.mark.parametrize(("limit", "rise", "overshoot"), [(0.3, 0.0, 0.1), (0.3, 0.3, 0.1), (1.0, 0.0, 0.2)])
def test_a_large_step_that_saturates_the_motor_does_not_wind_up(limit, rise, overshoot):
    source = Step(math.radians(90.0), rise=rise)
    time, result = turn(source, 8.0, limits=TorqueLimits(torque=limit))
    torque = result["control.motor_torque"]
    assert np.abs(torque).max() == pytest.approx(limit)
    assert result["control.limited"].any()
    assert result["gear_angle"].max() < (1.0 + overshoot) * math.radians(90.0)
    assert np.abs(result["gear_angle"][time > 1.5] - math.radians(90.0)).max() < math.radians(1.0)
    assert np.abs(np.diff(torque)).max() <= TorqueLimits().rate * STEP * (1.0 + 1e-9)


def test_after_a_load_that_no_torque_can_hold_control_is_back_at_once():
    push = np.where((np.arange(6000) > 2000) & (np.arange(6000) < 3000), 0.9, 0.0)
    time, result = turn(Step(0.0), 6.0, disturbance=push, limits=TorqueLimits(torque=0.6))
    assert np.abs(result["gear_angle"]).max() > 1.0
    assert np.abs(result["gear_angle"][time > 4.5]).max() < 0.02


def test_control_takes_hold_and_lets_go_without_a_blow():
    enabled = np.where((np.arange(4000) >= 500) & (np.arange(4000) < 2500), 1.0, 0.0)
    time, result = turn(Step(0.4, time=-1.0), 4.0, enabled=enabled)
    torque, hold = result["control.motor_torque"], result["control.hold"]
    assert not torque[:500].any()
    assert np.abs(np.diff(torque)[:510]).max() < 0.05
    assert not torque[time > 2.6].any()
    released = np.nonzero(hold[2500:] <= 0.0)[0][0] * STEP
    assert released == pytest.approx(CONTROL.limits.releasing, abs=2.0 * STEP)
    assert np.abs(result["gear_angle"][2000] - 0.4) < 1e-3


def test_missing_numbers_release_the_motor():
    missing = np.where((np.arange(3000) > 1500) & (np.arange(3000) < 1700), np.nan, 1.0)
    _, result = turn(Step(0.4), 3.0, enabled=missing)
    assert not result["control.motor_torque"][1610:1700].any()
    assert np.isfinite(result.values).all()
    assert result["control.hold"][-1] == 1.0


def test_the_integral_starts_anew_after_every_release():
    sample = CONTROL.Sample(ObservedColumn(*[0.0] * 5), Reference(*[0.0] * 5), 0.0)
    after, output = CONTROL.step(CONTROL.State(0.5, 3.0, 0.001), sample)
    assert (after.integral, output.hold) == (0.0, 0.0)


def test_the_regulated_column_is_damped():
    found = regulator(BELIEF, COLUMN.torsion_bar_stiffness, STEP)
    poles = np.log(found.eigenvalues[:5].astype(complex)) / STEP
    assert poles.real.max() < -3.0
    assert (-poles.real / np.abs(poles)).min() > 0.1


@pytest.mark.parametrize(
    ("made", "says"),
    [
        (lambda: replace(CONTROL, limits=TorqueLimits(torque=0.0)), "limits.torque is 0.0"),
        (lambda: replace(CONTROL, limits=TorqueLimits(rate=0.0)), "limits.rate is 0.0"),
        (lambda: replace(CONTROL, feed_forward=1.5), "feed_forward is 1.5"),
        (lambda: replace(CONTROL, friction=-0.1), "friction is -0.1"),
        (lambda: PositionControl.design(BELIEF, 140.0, weights={"shaft": -1.0, "shaft_integral": 1.0}), "is -1.0"),
        (lambda: PositionControl.design(BELIEF, 140.0, weights={"shaft": 1.0}), r"shaft_integral \(eigenvalue 1\)"),
        (lambda: PositionControl.design(BELIEF, 140.0, torque_weight=0.0), "above zero"),
        (lambda: PositionControl.design(BELIEF, 140.0, smoothing=-1.0), "smoothing is -1.0"),
        (lambda: PositionControl.design(BELIEF, 0.0), "torsion_bar_stiffness is 0.0"),
        (lambda: PositionControl.design(replace(BELIEF, motor_inertia=0.0), 140.0), "motor_inertia is 0.0"),
        (lambda: column_system(replace(BELIEF, stiffness=-1.0), 140.0, STEP), "stiffness is -1.0"),
    ],
)
def test_wrong_numbers_are_refused(made, says):
    with pytest.raises(ParameterError, match=says):
        made()
