"""Friction: Dahl's equation and its sensitivities, Coulomb, Stribeck, LuGre; lags solved over a sample."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tierod.physics import friction
from tierod.physics.friction import (
    RELAXED,
    BuildUp,
    damped_rotation,
    exponential_build_up,
    finite_build_up,
    gauss_markov_noise,
    lagged_ramp,
    long_build_up,
)
from tierod_lab.ground.laws import dahl_power_update

ANGLE = math.radians(1.0)


@given(st.floats(-1, 1), st.floats(-5, 5))
def test_the_mean_of_dahls_friction_is_that_over_its_path(start, turned):
    path = np.linspace(0.0, turned * ANGLE, 2001)
    values = np.array([friction.dahl_update(start, angle, ANGLE) for angle in path])
    mean = np.mean(0.5 * (values[1:] + values[:-1]))
    assert friction.dahl_mean(start, turned * ANGLE, ANGLE) == pytest.approx(mean, abs=1e-5)


@pytest.mark.parametrize("amplitude", [0.5, 2.0, 20.0])
def test_area_of_the_steady_loop_is_the_friction_work(amplitude):
    swing = amplitude * ANGLE
    path = swing * np.sin(np.linspace(0.0, 6.0 * math.pi, 60_001))
    normalised, trace = 0.0, []
    for increment in np.diff(path).tolist():
        before = normalised
        normalised = friction.dahl_update(normalised, increment, ANGLE)
        trace.append(0.5 * (before + normalised) * increment)
    work = sum(trace[-20_000:])
    start = math.tanh(amplitude)
    area = 2.0 * (2.0 * swing - (1.0 + start) * ANGLE * -math.expm1(-2.0 * amplitude))
    assert work == pytest.approx(area, rel=0.01)


@given(st.floats(-1, 1), st.floats(-3, 3).filter(lambda turned: abs(turned) > 1e-3))
def test_sensitivity_is_the_derivative_for_the_logarithm_of_the_angle(start, turned):
    step = 1e-6
    up = friction.dahl_update(start, turned * ANGLE, ANGLE * math.exp(step))
    down = friction.dahl_update(start, turned * ANGLE, ANGLE * math.exp(-step))
    slope = friction.dahl_sensitivity_update(0.0, start, turned * ANGLE, ANGLE)
    assert slope == pytest.approx((up - down) / (2.0 * step), abs=1e-7)


LAWS = [(finite_build_up, 0.5), (exponential_build_up, 1.0), (long_build_up, 2.0)]
level_values = st.floats(-1.0, 1.0)
increments = st.floats(-0.2, 0.2)
angles = st.floats(math.radians(0.05), math.radians(8.0))


@pytest.mark.parametrize(("law", "exponent"), LAWS)
@given(level=level_values, increment=increments, angle=angles)
def test_agrees_with_the_general_solution_of_dahls_equation(law, exponent, level, increment, angle):
    general = dahl_power_update(level, increment, angle, exponent) if increment else level
    assert law(BuildUp(level, 0.0), increment, angle).level == pytest.approx(general, abs=1e-9)


@pytest.mark.parametrize(("law", "exponent"), LAWS)
def test_sensitivity_is_the_derivative_over_a_whole_path(law, exponent):
    path = [0.004, 0.01, 0.02, -0.003, -0.012, -0.05, 0.006, 0.001, -0.002, 0.009]

    def end(log_angle):
        state = RELAXED
        for increment in path:
            state = law(state, increment, math.exp(log_angle))
        return state

    at, step = math.log(math.radians(2.0)), 1e-6
    difference = (end(at + step).level - end(at - step).level) / (2.0 * step)
    assert abs(difference) > 1e-3
    assert end(at).sensitivity == pytest.approx(difference, rel=1e-5)


@pytest.mark.parametrize("lag", [0.003, 0.01, 0.4])
def test_it_solves_the_equation_of_the_lag(lag):
    before, after, output, time = 1.0, 3.0, -0.5, 0.01

    def slope(t, y):
        rate = (before + (after - before) * t / time - y[0]) / lag
        return [rate, y[0]]

    solved = solve_ivp(slope, (0.0, time), [output, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    ours = lagged_ramp(before, after, output, lag, time)
    assert (ours.end, ours.mean) == pytest.approx((solved[0], solved[1] / time), rel=1e-7)


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
