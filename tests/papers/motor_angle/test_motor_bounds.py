"""Intervals of a motor whose currents are written down in closed form."""

import numpy as np
import pytest

from tierod.core.errors import InputError
from tierod.methods.identification.motor_recording import MotorRecording
from tierod_lab.papers.motor_angle.motor_bounds import MotorErrorBounds, guaranteed_motor

R, L, PSI, PAIRS, STEP = 0.05, 1e-4, 0.0085, 4.0, 1e-4
BOUNDS = MotorErrorBounds(0.26, 0.05, 8.7e-4, 2e6)


def seen(errors=1.0, resistance=R, seed=1):
    """A shaft that swings and currents that swing otherwise; the mean voltage of each step is the exact integral."""
    time = STEP * np.arange(20000)
    angle = 3.0 * np.sin(20.0 * time)
    rates, sizes = np.array([40.0, -700.0, 11.0]), np.array([12.0, 6.0 - 2.0j, 15.0j])
    current = np.sum(sizes * np.exp(1j * np.outer(time, rates)), axis=1)
    charge = np.sum(sizes / (1j * rates) * np.exp(1j * np.outer(time, rates)), axis=1)
    flux = L * current + PSI * np.exp(1j * PAIRS * angle)
    voltage = np.concatenate([[0.0], np.diff(resistance * charge + flux) / STEP])
    random = np.random.default_rng(seed)

    def noise(bound):
        return errors * bound * random.uniform(-1.0, 1.0, len(time))

    return MotorRecording(
        "drive",
        STEP,
        time,
        current + noise(0.26) + 1j * noise(0.26),
        voltage + noise(0.05) + 1j * noise(0.05),
        angle + noise(8.7e-4),
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_truth_lies_within_and_the_box_is_narrow(seed):
    box = guaranteed_motor([seen(seed=seed)], PAIRS, BOUNDS)
    true = np.array([R, L, PSI])
    assert (box.low <= true).all()
    assert (true <= box.high).all()
    assert (box.half_width / true < [0.1, 0.5, 0.05]).all()


def test_more_windows_make_it_no_wider():
    every, some = (guaranteed_motor([seen()], PAIRS, BOUNDS, lengths) for lengths in ((16, 64), (16,)))
    assert (every.low >= some.low - 1e-9).all()
    assert (every.high <= some.high + 1e-9).all()
    assert (every.half_width < some.half_width).any()


def test_bounds_that_are_too_small_leave_nothing():
    tight = MotorErrorBounds(0.02, 0.004, 1e-5, 2e6)
    with pytest.raises(InputError, match="a bound is too small"):
        guaranteed_motor([seen()], PAIRS, tight)
    with pytest.raises(InputError, match="a bound is too small"):
        guaranteed_motor([seen(), seen(resistance=2.0 * R)], PAIRS, BOUNDS)


def test_a_gap_costs_its_windows_only_and_no_window_is_said():
    broken = seen()
    broken.current[5000:6000] = np.nan
    assert guaranteed_motor([broken], PAIRS, BOUNDS).low[0] > 0.0
    broken.current[::3] = np.nan
    with pytest.raises(InputError, match="no window"):
        guaranteed_motor([broken], PAIRS, BOUNDS)
