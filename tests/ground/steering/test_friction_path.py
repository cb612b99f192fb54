"""Laws solved over a path, against the published differential equations integrated by other means."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tierod.physics.friction import dahl_update, lugre_bristle_rate, lugre_torque, stribeck_level
from tierod_lab.ground.steering.friction_path import elastoplastic_update, lugre_share, lugre_update

ANGLE = math.radians(1.0)


@pytest.mark.parametrize("rate", [-3.0, 0.02, 0.5])
@pytest.mark.parametrize("start", [-0.9, 0.0, 0.6])
def test_bristles_over_a_stroke_at_a_constant_rate_are_the_published_equation(rate, start):
    level, stiffness, micro = 4.0, 4.0 / ANGLE, 0.4
    steady = stribeck_level(rate, 1.3 * level, level, 0.1)
    turned = math.copysign(1.7 * ANGLE, rate)
    solved = solve_ivp(
        lambda _, z: [lugre_bristle_rate(z[0], rate, stiffness, steady)],
        (0.0, turned / rate),
        [start * level / stiffness],
        rtol=1e-10,
        atol=1e-14,
    )
    deflection = float(solved.y[0, -1])
    bristle = lugre_update(start, turned, ANGLE, steady / level)
    assert bristle == pytest.approx(deflection * stiffness / level, abs=1e-8)
    bristle_rate = lugre_bristle_rate(deflection, rate, stiffness, steady)
    torque = lugre_torque(deflection, bristle_rate, rate, stiffness, micro, 0.0)
    share = lugre_share(bristle, rate, ANGLE, steady / level, micro / stiffness)
    assert level * share == pytest.approx(torque, abs=1e-7)


@given(st.floats(-1, 1), st.floats(-0.2, 0.2))
def test_bristles_of_a_flat_curve_are_dahls_law(start, turned):
    assert lugre_update(start, turned, ANGLE, 1.0) == pytest.approx(dahl_update(start, turned, ANGLE), abs=1e-14)
    assert lugre_share(start, 0.0, ANGLE, 1.0, 2e-3) == start


@given(st.floats(-1, 1), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_elastic_element_slips_at_its_level(start, first, second):
    after = elastoplastic_update(start, first, ANGLE)
    assert -1.0 <= after <= 1.0
    if abs(start + first / ANGLE) <= 1.0:
        assert after == start + first / ANGLE
    if first * second > 0.0:
        assert elastoplastic_update(after, second, ANGLE) == pytest.approx(
            elastoplastic_update(start, first + second, ANGLE), abs=1e-12
        )
