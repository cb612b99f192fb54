"""Angles within half a turn, against the two-argument arctangent."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.clarke_park import wrapped


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
