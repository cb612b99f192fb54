import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.lash import lash_torque

STIFFNESS, DAMPING, PLAY = 2000.0, 0.5, 0.01


def test_dead_zone_is_as_wide_as_the_play():
    twist = np.linspace(-0.02, 0.02, 4001)
    torque = lash_torque(twist, 0.0 * twist, STIFFNESS, DAMPING, PLAY)
    free = twist[torque == 0.0]
    assert free[-1] - free[0] == pytest.approx(PLAY, abs=2.1e-5)
    assert lash_torque(0.5 * PLAY + 1e-3, 0.0, STIFFNESS, DAMPING, PLAY) == pytest.approx(2.0)
    assert lash_torque(-0.5 * PLAY - 1e-3, 0.0, STIFFNESS, DAMPING, PLAY) == pytest.approx(-2.0)


@given(st.floats(-0.05, 0.05), st.floats(-10, 10), st.floats(1e-5, 0.02))
def test_flanks_push_and_never_pull(twist, rate, play):
    torque = lash_torque(twist, rate, STIFFNESS, DAMPING, play)
    assert torque * twist >= 0.0
    assert lash_torque(-twist, -rate, STIFFNESS, DAMPING, play) == -torque


@given(st.floats(-0.05, 0.05), st.floats(-10, 10))
def test_without_play_it_is_a_spring_and_a_damper(twist, rate):
    assert lash_torque(twist, rate, STIFFNESS, DAMPING, 0.0) == STIFFNESS * twist + DAMPING * rate
