"""friction"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import friction
from tierod.physics.friction import (
    RELAXED,
    BuildUp,
    dahl_power_update,
    exponential_build_up,
    finite_build_up,
    long_build_up,
)

ANGLE = math.radians(1.0)


def integrated(normalised, increment, angle, exponent, steps=20_000):
    """A slow oracle: Dahl's equation, 1976, by many small midpoint steps, (n,) at once."""
    direction, part = np.copysign(1.0, increment), increment / steps

    def slope(level):
        gap = 1.0 - level * direction
        return np.abs(gap) ** exponent * np.sign(gap) / angle

    for _ in range(steps):
        normalised = normalised + part * slope(normalised + 0.5 * part * slope(normalised))
    return normalised


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 3.0])
def test_closed_form_is_the_integral_of_dahls_equation(exponent):
    starts, turns = np.meshgrid([-1.0, -0.4, 0.0, 0.7], [-2.0, -0.1, 0.3, 1.7])
    found = integrated(starts.ravel(), turns.ravel() * ANGLE, ANGLE, exponent)
    for start, turned, each in zip(starts.ravel(), turns.ravel(), found, strict=True):
        exact = friction.dahl_power_update(start, turned * ANGLE, ANGLE, exponent)
        assert exact == pytest.approx(each, abs=2e-4), (start, turned)


@given(st.floats(-1, 1), st.floats(-5, 5))
def test_exponent_one_is_the_exponential(start, turned):
    plain = friction.dahl_update(start, turned * ANGLE, ANGLE)
    assert friction.dahl_power_update(start, turned * ANGLE, ANGLE, 1.0) == pytest.approx(plain, abs=1e-12)
    assert friction.dahl_power_update(start, turned * ANGLE, ANGLE, 1.0 + 1e-5) == pytest.approx(plain, abs=2e-4)


@given(st.floats(-1, 1), st.floats(-5, 5))
def test_the_mean_of_dahls_friction_is_that_over_its_path(start, turned):
    path = np.linspace(0.0, turned * ANGLE, 2001)
    values = np.array([friction.dahl_update(start, angle, ANGLE) for angle in path])
    mean = np.mean(0.5 * (values[1:] + values[:-1]))
    assert friction.dahl_mean(start, turned * ANGLE, ANGLE) == pytest.approx(mean, abs=1e-5)


@given(st.floats(-1, 1), st.floats(-20, 20), st.floats(0.0, 5.0))
def test_dahl_stays_between_the_levels(start, turned, exponent):
    after = friction.dahl_power_update(start, turned * ANGLE, ANGLE, exponent)
    assert -1.0 - 1e-12 <= after <= 1.0 + 1e-12


@given(st.floats(-1, 1), st.floats(0.0, 3.0), st.floats(0.0, 3.0), st.floats(0.2, 4.0))
def test_two_increments_are_one(start, first, second, exponent):
    halves = friction.dahl_power_update(
        friction.dahl_power_update(start, first * ANGLE, ANGLE, exponent), second * ANGLE, ANGLE, exponent
    )
    assert halves == pytest.approx(
        friction.dahl_power_update(start, (first + second) * ANGLE, ANGLE, exponent), abs=1e-9
    )


@given(st.floats(-1, 1), st.floats(0.0, 4.0))
def test_no_motion_changes_nothing(start, exponent):
    assert friction.dahl_update(start, 0.0, ANGLE) == start
    assert friction.dahl_power_update(start, 0.0, ANGLE, exponent) == pytest.approx(start, abs=1e-15)


def test_exponent_below_one_reaches_the_level_after_a_finite_travel():
    assert friction.dahl_power_update(-1.0, 2.0 * math.sqrt(2.0) * ANGLE * 1.001, ANGLE, 0.5) == 1.0
    assert friction.dahl_power_update(-1.0, 2.0 * math.sqrt(2.0) * ANGLE * 0.9, ANGLE, 0.5) < 1.0


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


def test_coulomb_and_its_smooth_form_agree_in_motion():
    assert friction.coulomb(-0.4, 5.0) == -5.0
    assert friction.coulomb(0.0, 5.0) == 0.0
    assert friction.smooth_coulomb(0.4, 5.0, 0.02) == pytest.approx(5.0)
    assert friction.smooth_coulomb(0.02, 5.0, 0.02) == pytest.approx(5.0 * 0.7616, rel=1e-4)


def test_stribeck_falls_from_static_to_sliding():
    assert friction.stribeck_level(0.0, 6.0, 4.0, 0.1) == pytest.approx(6.0)
    assert friction.stribeck_level(-0.1, 6.0, 4.0, 0.1) == pytest.approx(4.0 + 2.0 / math.e)
    assert friction.stribeck_level(5.0, 6.0, 4.0, 0.1) == pytest.approx(4.0)


def test_lugre_settles_at_the_steady_curve_and_equals_dahl_without_damping():
    stiffness, level, rate, deflection, step = 400.0, 4.0, 0.3, 0.0, 1e-5
    for _ in range(20_000):
        deflection += step * friction.lugre_bristle_rate(deflection, rate, stiffness, level)
    torque = friction.lugre_torque(deflection, 0.0, rate, stiffness, 0.0, 0.0)
    dahl = level * friction.dahl_update(0.0, 20_000 * step * rate, level / stiffness)
    assert torque == pytest.approx(dahl, rel=1e-3)
    settled = friction.lugre_torque(level / stiffness, 0.0, rate, stiffness, 1.0, 0.8)
    assert settled == pytest.approx(level + 0.8 * rate)


def test_laws_take_arrays():
    rates = np.array([-1.0, 0.0, 2.0])
    np.testing.assert_array_equal(friction.coulomb(rates, 3.0), [-3.0, 0.0, 3.0])
    np.testing.assert_array_equal(friction.viscous(rates, 0.5), [-0.5, 0.0, 1.0])
    many = friction.dahl_power_update(np.zeros(3), rates * ANGLE, ANGLE, 0.5)
    np.testing.assert_allclose(many, [friction.dahl_power_update(0.0, r * ANGLE, ANGLE, 0.5) for r in rates.tolist()])


LAWS = [(finite_build_up, 0.5), (exponential_build_up, 1.0), (long_build_up, 2.0)]
levels = st.floats(-1.0, 1.0)
increments = st.floats(-0.2, 0.2)
angles = st.floats(math.radians(0.05), math.radians(8.0))


@pytest.mark.parametrize(("law", "exponent"), LAWS)
@given(level=levels, increment=increments, angle=angles)
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


@pytest.mark.parametrize(("law", "exponent"), LAWS)
@given(level=levels, sensitivity=st.floats(-2.0, 2.0), angle=angles)
def test_without_motion_nothing_changes(law, exponent, level, sensitivity, angle):
    state = BuildUp(level, sensitivity)
    assert tuple(law(state, 0.0, angle)) == pytest.approx(tuple(state), abs=1e-15)


@pytest.mark.parametrize(("law", "exponent"), LAWS)
@given(level=levels, increment=increments, angle=angles)
def test_friction_never_exceeds_its_level(law, exponent, level, increment, angle):
    after = law(BuildUp(level, 0.0), increment, angle)
    assert abs(after.level) <= 1.0 + 1e-12
    assert math.isfinite(after.sensitivity)
    assert (after.level - level) * increment >= -1e-15
