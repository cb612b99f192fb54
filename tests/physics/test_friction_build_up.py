import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.friction import (
    RELAXED,
    BuildUp,
    dahl_power_update,
    exponential_build_up,
    finite_build_up,
    long_build_up,
)

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
