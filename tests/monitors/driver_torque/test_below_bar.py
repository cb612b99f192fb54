import numpy as np
import pytest

from tierod.monitors.driver_torque.column_regression import BelowBarOverDrive

INERTIA, RATIO = 1.6e-4, 18.0


def signals(size=9.0):
    time = np.arange(30_000) * 1e-3
    angle = size * (np.sin(2.0 * np.pi * 1.1 * time) + 0.5 * np.sin(2.0 * np.pi * 2.3 * time))
    speed, bar = np.gradient(angle, 1e-3), 0.8 * np.sin(2.0 * np.pi * 0.4 * time)
    motor = INERTIA * np.gradient(speed, 1e-3) + 2e-3 * speed + 0.1 * np.tanh(2.0 * speed) - bar / RATIO
    return motor, angle + 3e-3 * np.random.default_rng(4).standard_normal(len(time)), bar


def test_inertia_comes_out_beside_damping_and_friction():
    below, (motor, angle, bar) = BelowBarOverDrive(RATIO, 1000.0), signals()
    motor[::7] = np.nan
    for piece in zip(*(np.array_split(each, 5) for each in (motor, angle, bar)), strict=True):
        below.add(*piece)
    assert below.inertia() == pytest.approx(INERTIA, rel=0.05)


def test_a_motor_that_hardly_moves_tells_nothing():
    below = BelowBarOverDrive(RATIO, 1000.0)
    assert below.inertia() is None
    below.add(*signals(size=0.01))
    assert below.inertia() is None
