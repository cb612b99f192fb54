"""Angles within half a turn, against the two-argument arctangent."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.clarke_park import (
    Direction,
    PhaseValues,
    RotorVector,
    StatorVector,
    clarke,
    direction,
    electrical_angle,
    inverse_clarke,
    inverse_park,
    park,
    turned,
    wrapped,
)

VALUE = st.floats(-1e3, 1e3)
ANGLE = st.floats(-1e3, 1e3)


@given(VALUE, VALUE)
def test_clarke_inverts(alpha, beta):
    np.testing.assert_allclose(clarke(inverse_clarke(StatorVector(alpha, beta))), (alpha, beta), atol=1e-10)


@given(VALUE, VALUE)
def test_without_common_part_it_is_the_printed_transform(a, b):
    alpha, beta = clarke(PhaseValues(a, b, -a - b))
    assert alpha == pytest.approx(a, abs=1e-10)
    assert beta == pytest.approx(a / math.sqrt(3.0) + 2.0 * b / math.sqrt(3.0), abs=1e-10)


@given(VALUE, VALUE, VALUE, VALUE)
def test_what_phases_share_drops_out(a, b, c, common):
    shifted = clarke(PhaseValues(a + common, b + common, c + common))
    np.testing.assert_allclose(shifted, clarke(PhaseValues(a, b, c)), atol=1e-9)


@given(VALUE, VALUE, ANGLE)
def test_park_inverts_and_keeps_the_length(alpha, beta, angle):
    rotor = direction(angle)
    own = park(StatorVector(alpha, beta), rotor)
    np.testing.assert_allclose(inverse_park(own, rotor), (alpha, beta), atol=1e-9)
    assert math.hypot(*own) == pytest.approx(math.hypot(alpha, beta), abs=1e-9)


@given(st.floats(0.1, 100.0), ANGLE, st.floats(-3.0, 3.0))
def test_balanced_sines_stand_still_in_the_rotor_and_keep_their_amplitude(amplitude, angle, lead):
    phases = PhaseValues(*(amplitude * math.cos(angle + lead - k * 2.0 * math.pi / 3.0) for k in range(3)))
    own = park(clarke(phases), direction(angle))
    np.testing.assert_allclose(own, (amplitude * math.cos(lead), amplitude * math.sin(lead)), atol=1e-9)


def test_a_positive_quadrature_current_leads_the_flux():
    np.testing.assert_allclose(inverse_park(RotorVector(0.0, 1.0), direction(0.0)), (0.0, 1.0), atol=1e-15)


@given(st.floats(-3.0, 3.0), st.floats(-0.3, 0.3))
def test_turning_by_a_small_angle(angle, increment):
    np.testing.assert_allclose(turned(direction(angle), increment), direction(angle + increment), atol=1e-6)


def test_many_small_turns_add_up():
    now = Direction(1.0, 0.0)
    for _ in range(10):
        now = turned(now, 0.1)
    np.testing.assert_allclose(now, direction(1.0), atol=2e-8)


def test_electrical_turns_are_more_than_mechanical_ones():
    assert electrical_angle(0.5, 4) == 2.0


@given(st.floats(-200.0, 200.0))
def test_it_is_the_same_direction_within_half_a_turn(angle):
    found = wrapped(angle)
    assert -math.pi <= found <= math.pi
    assert math.cos(found - angle) == pytest.approx(1.0, abs=1e-9)


def test_half_a_turn_is_negative_and_small_angles_stay():
    assert wrapped(math.pi) == -math.pi
    assert wrapped(-math.pi) == -math.pi
    assert wrapped(0.3) == 0.3
    assert wrapped(0.3 + 6.0 * math.pi) == pytest.approx(0.3)
