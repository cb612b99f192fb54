import numpy as np
import pytest

from tierod.monitors.driver_torque.column import BelowBarOverDrive, GeometryOverDrive

RATIO, STIFFNESS = 18.0, 140.0


def signals(count=20_000, noise=1e-4):
    draw, time = np.random.default_rng(3), np.arange(count) * 1e-3
    motor = 20.0 * np.sin(2.0 * np.pi * 0.4 * time) + 5.0
    bar = 2.0 * np.sin(2.0 * np.pi * 1.3 * time)
    wheel = motor / RATIO + bar / STIFFNESS - 0.7
    return wheel + noise * draw.standard_normal(count), motor, bar + 0.01 * draw.standard_normal(count)


def test_ratio_and_stiffness_come_out_whatever_the_offset():
    geometry = GeometryOverDrive()
    geometry.add(*signals())
    found = geometry.found()
    assert found.ratio == pytest.approx(RATIO, rel=1e-4)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=0.01)


@pytest.mark.parametrize("stretch", [0.03, 1.0])
def test_an_error_that_goes_with_a_short_motion_moves_the_ratio_within_its_uncertainty(stretch):
    _, motor, bar = signals()
    motor = stretch * (motor - 5.0)
    going = 8e-4 * np.sign(np.diff(motor, append=motor[-1]))
    geometry = GeometryOverDrive()
    geometry.add(motor / RATIO + bar / STIFFNESS + going + 3e-4 * np.sign(motor), motor, bar)
    found = geometry.found()
    assert abs(found.ratio / RATIO - 1.0) < 3.0 * found.ratio_uncertainty
    assert (found.ratio_uncertainty > 0.01) == (stretch < 1.0)


def test_pieces_add_up_and_missing_samples_are_left_out():
    whole, parts, rows = GeometryOverDrive(), GeometryOverDrive(), np.array(signals())
    whole.add(*rows)
    rows[1, ::5] = np.nan
    for part in np.array_split(rows, 7, axis=1):
        parts.add(*part)
    assert parts.found().ratio == pytest.approx(whole.found().ratio, rel=1e-4)


def test_a_wrong_sign_names_neither():
    geometry, (wheel, motor, bar) = GeometryOverDrive(), signals()
    geometry.add(wheel, motor, -bar)
    assert geometry.found() is None


def test_too_little_names_neither():
    few, still = GeometryOverDrive(), GeometryOverDrive()
    few.add(*signals(100))
    still.add(*np.zeros((3, 2000)))
    assert few.found() is None
    assert still.found() is None


def test_the_constant_is_the_offset_of_the_torque_where_the_angles_are_set_to_zero():
    geometry, (wheel, motor, bar) = GeometryOverDrive(), signals()
    geometry.add(wheel + 0.7, motor, bar + 0.5)
    assert geometry.found().torque_offset == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("late", range(3))
@pytest.mark.parametrize("lag", [5, 20])
def test_the_signal_that_is_late_is_named(late, lag):
    geometry, rows = GeometryOverDrive(), list(signals())
    rows = [row[lag - lag * (k == late) : len(row) - lag * (k == late)] for k, row in enumerate(rows)]
    geometry.add(*rows)
    found = geometry.found()
    assert found.late == ("steering_wheel_angle", "motor_angle_mechanical", "driver_torque")[late]
    assert found.lag == pytest.approx(1e-3 * lag, rel=0.1)


def test_what_is_on_time_has_next_to_no_lag():
    geometry = GeometryOverDrive()
    geometry.add(*signals())
    assert abs(geometry.found().lag) < 1e-3


INERTIA, RATIO = 1.6e-4, 18.0


def bench_signals(size=9.0):
    time = np.arange(30_000) * 1e-3
    angle = size * (np.sin(2.0 * np.pi * 1.1 * time) + 0.5 * np.sin(2.0 * np.pi * 2.3 * time))
    speed, bar = np.gradient(angle, 1e-3), 0.8 * np.sin(2.0 * np.pi * 0.4 * time)
    motor = INERTIA * np.gradient(speed, 1e-3) + 2e-3 * speed + 0.1 * np.tanh(2.0 * speed) - bar / RATIO
    return motor, angle + 3e-3 * np.random.default_rng(4).standard_normal(len(time)), bar


def test_inertia_comes_out_beside_damping_and_friction():
    below, (motor, angle, bar) = BelowBarOverDrive(RATIO, 1000.0), bench_signals()
    motor[::7] = np.nan
    for piece in zip(*(np.array_split(each, 5) for each in (motor, angle, bar)), strict=True):
        below.add(*piece)
    assert below.inertia() == pytest.approx(INERTIA, rel=0.05)


def test_a_motor_that_hardly_moves_shows_nothing():
    below = BelowBarOverDrive(RATIO, 1000.0)
    assert below.inertia() is None
    below.add(*bench_signals(size=0.01))
    assert below.inertia() is None
