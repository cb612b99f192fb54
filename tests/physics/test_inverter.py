import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.clarke_park import PhaseValues, RotorVector, StatorVector, inverse_clarke
from tierod.physics.inverter import (
    LONGEST_SIGN,
    commanded_voltage,
    limited_voltage,
    longest_voltage,
    lost_voltage,
    phase_signs,
)

VALUE = st.floats(-100.0, 100.0)


@given(st.floats(-math.pi, math.pi))
def test_the_longest_vector_can_be_made_in_every_direction_and_just_so(angle):
    length = longest_voltage(13.0)
    phases = inverse_clarke(StatorVector(length * math.cos(angle), length * math.sin(angle)))
    assert max(phases) - min(phases) <= 13.0 * (1.0 + 1e-12)


def test_a_longer_vector_cannot_be_made_everywhere():
    length = 1.001 * longest_voltage(13.0)
    spans = [
        max(phases) - min(phases)
        for angle in np.linspace(0.0, math.pi, 200)
        for phases in [inverse_clarke(StatorVector(length * math.cos(angle), length * math.sin(angle)))]
    ]
    assert max(spans) > 13.0


@given(VALUE, VALUE)
def test_limit_keeps_the_direction_and_short_vectors(d, q):
    wanted = RotorVector(d, q)
    made = limited_voltage(wanted, 7.5)
    assert isinstance(made, RotorVector)
    assert math.hypot(*made) <= 7.5 * (1.0 + 1e-12)
    assert made.d * q == pytest.approx(made.q * d, abs=1e-9)
    if math.hypot(d, q) < 7.5:
        np.testing.assert_allclose(made, wanted, rtol=1e-12)


def test_loss_of_currents_far_above_the_knee():
    lost = lost_voltage(StatorVector(20.0, 0.0), 13.0, 1e-6, 1e-4, 0.7, 1.0)
    np.testing.assert_allclose(lost, ((13.0 * 0.01 + 0.7) * 4.0 / 3.0, 0.0), atol=1e-12)


def test_loss_of_small_currents_is_a_resistance():
    current = StatorVector(0.2, -0.1)
    lost = lost_voltage(current, 13.0, 1e-6, 1e-4, 0.7, 1.0)
    np.testing.assert_allclose(lost, np.multiply(current, 13.0 * 0.01 + 0.7), atol=1e-12)


@given(VALUE, VALUE)
def test_loss_never_gives_power(alpha, beta):
    current = StatorVector(alpha, beta)
    assert np.dot(lost_voltage(current, 13.0, 1e-6, 1e-4, 0.7, 1.0), current) >= 0.0


@given(st.floats(-math.pi, math.pi))
def test_the_vector_of_three_signs_points_to_the_middle_of_its_sixth(angle):
    current = StatorVector(50.0 * math.cos(angle), 50.0 * math.sin(angle))
    signs = phase_signs(current, 1e-9)
    if min(abs(value) for value in inverse_clarke(current)) > 1e-6:
        assert math.hypot(*signs) == pytest.approx(LONGEST_SIGN)
        assert np.dot(signs, current) > 0.8 * LONGEST_SIGN * 50.0


def test_duty_cycles_of_one_leg_reach_two_thirds_of_the_supply():
    np.testing.assert_allclose(commanded_voltage(PhaseValues(1.0, 0.0, 0.0), 13.0), (13.0 * 2.0 / 3.0, 0.0), atol=1e-12)


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 0.3))
def test_duty_cycles_give_what_they_were_made_for_whatever_all_legs_share(angle, shared):
    wanted = StatorVector(3.0 * math.cos(angle), 3.0 * math.sin(angle))
    duty = PhaseValues(*(0.4 + shared + value / 13.0 for value in inverse_clarke(wanted)))
    np.testing.assert_allclose(commanded_voltage(duty, 13.0), wanted, atol=1e-12)
