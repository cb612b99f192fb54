"""Ratio, stiffness, offset and lag of a column from its three signals, and the inertia below the bar."""

import numpy as np
import pytest

from tierod.monitors.driver_torque.column import SIGNALS, BelowBarOverDrive, GeometryOverDrive

RATIO, STIFFNESS, INERTIA = 18.0, 140.0, 1.6e-4


def signals(count=20_000, noise=1e-4):
    draw, time = np.random.default_rng(3), np.arange(count) * 1e-3
    motor = 20.0 * np.sin(2.0 * np.pi * 0.4 * time) + 5.0
    bar = 2.0 * np.sin(2.0 * np.pi * 1.3 * time)
    wheel = motor / RATIO + bar / STIFFNESS - 0.7
    return np.array([wheel + noise * draw.standard_normal(count), motor, bar + 0.01 * draw.standard_normal(count)])


def found(rows, pieces=1):
    geometry = GeometryOverDrive()
    for part in np.array_split(np.asarray(rows), pieces, axis=1):
        geometry.add(*part)
    return geometry.found()


def test_ratio_stiffness_and_offset_come_out_however_the_drive_is_cut_and_with_missing_samples():
    gaps = signals() + np.array([[0.7], [0.0], [0.5]])
    gaps[1, ::5] = np.nan
    for each in (found(signals()), found(gaps, 7)):
        assert each.ratio == pytest.approx(RATIO, rel=1e-4)
        assert each.stiffness == pytest.approx(STIFFNESS, rel=0.01)
        assert abs(each.lag) < 1e-3
    assert found(gaps).torque_offset == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("stretch", [0.03, 1.0])
def test_an_error_that_goes_with_a_short_motion_moves_the_ratio_within_its_uncertainty(stretch):
    _, motor, bar = signals()
    motor = stretch * (motor - 5.0)
    going = 8e-4 * np.sign(np.diff(motor, append=motor[-1]))
    geometry = found([motor / RATIO + bar / STIFFNESS + going + 3e-4 * np.sign(motor), motor, bar])
    assert abs(geometry.ratio / RATIO - 1.0) < 3.0 * geometry.ratio_uncertainty
    assert (geometry.ratio_uncertainty > 0.01) == (stretch < 1.0)


def test_a_wrong_sign_and_too_little_motion_give_nothing():
    wheel, motor, bar = signals()
    assert found([wheel, motor, -bar]) is found(signals(100)) is found(np.zeros((3, 2000))) is None


@pytest.mark.parametrize("late", range(3))
@pytest.mark.parametrize("lag", [5, 20])
def test_the_signal_that_is_late_is_named(late, lag):
    rows = list(signals())
    geometry = found([row[lag - lag * (k == late) : len(row) - lag * (k == late)] for k, row in enumerate(rows)])
    assert geometry.late == SIGNALS[late]
    assert geometry.lag == pytest.approx(1e-3 * lag, rel=0.1)


@pytest.mark.parametrize(("size", "known"), [(9.0, True), (0.01, False)])
def test_inertia_comes_out_beside_damping_and_friction_where_the_motor_moves(size, known):
    time = np.arange(30_000) * 1e-3
    angle = size * (np.sin(2.0 * np.pi * 1.1 * time) + 0.5 * np.sin(2.0 * np.pi * 2.3 * time))
    speed, bar = np.gradient(angle, 1e-3), 0.8 * np.sin(2.0 * np.pi * 0.4 * time)
    motor = INERTIA * np.gradient(speed, 1e-3) + 2e-3 * speed + 0.1 * np.tanh(2.0 * speed) - bar / RATIO
    motor[::7] = np.nan
    below = BelowBarOverDrive(RATIO, 1000.0)
    assert below.inertia() is None
    noisy = angle + 3e-3 * np.random.default_rng(4).standard_normal(len(time))
    for piece in zip(*(np.array_split(each, 5) for each in (motor, noisy, bar)), strict=True):
        below.add(*piece)
    assert below.inertia() == (pytest.approx(INERTIA, rel=0.05) if known else None)
