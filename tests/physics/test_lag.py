"""Linear motions solved exactly over a sample: a lag of the first order, noise that it shapes, a damped rotation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tierod.physics.lag import damped_rotation, gauss_markov_noise, lagged_ramp, share_reached


@pytest.mark.parametrize("lag", [0.003, 0.01, 0.4])
def test_it_solves_the_equation_of_the_lag(lag):
    before, after, output, time = 1.0, 3.0, -0.5, 0.01

    def slope(t, y):
        rate = (before + (after - before) * t / time - y[0]) / lag
        return [rate, y[0]]

    solved = solve_ivp(slope, (0.0, time), [output, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    ours = lagged_ramp(before, after, output, lag, time)
    assert (ours.end, ours.mean) == pytest.approx((solved[0], solved[1] / time), rel=1e-7)


def test_without_a_lag_it_follows():
    assert lagged_ramp(1.0, 3.0, 1.0, 0.0, 0.01) == pytest.approx((2.0, 3.0), abs=0.03)
    assert np.isfinite(lagged_ramp(1.0, 3.0, 1.0, 0.0, 1.0)).all()


def test_the_share_of_a_step_is_that_of_the_equation():
    solved = solve_ivp(lambda t, y: (1.0 - y) / 0.4, (0.0, 0.1), [0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert share_reached(0.1 / 0.4) == pytest.approx(solved, rel=1e-8)
    assert share_reached(1e-20) == 1e-20


def test_the_noise_of_a_gauss_markov_process_keeps_its_deviation():
    deviation, time, step, variance = 0.3, 2.0, 0.01, 0.0
    for _ in range(20_000):
        variance = np.exp(-2.0 * step / time) * variance + gauss_markov_noise(deviation, time, step)
    assert np.sqrt(variance) == pytest.approx(deviation, rel=1e-9)


@pytest.mark.parametrize(("inertia", "damping", "time"), [(0.045, 1.07, 0.01), (0.045, 20.0, 0.1), (2.0, 0.5, 0.3)])
def test_it_solves_the_equation_of_motion(inertia, damping, time):
    system = np.zeros((3, 3))
    system[0, 1], system[1, 1], system[1, 2] = 1.0, -damping / inertia, 1.0 / inertia
    exact = expm(time * system)
    ours = damped_rotation(inertia, damping, time)
    expected = (exact[1, 1], exact[0, 1], exact[1, 2], exact[0, 2])
    assert ours == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 1e-12])
def test_without_damping_it_is_a_free_body(damping):
    inertia, time = 0.05, 0.01
    ours = damped_rotation(inertia, damping, time)
    assert ours == pytest.approx((1.0, time, time / inertia, 0.5 * time * time / inertia), rel=1e-4)
