"""Gears and rack: elastic meshing, superposition of two turns, lash, end stops, and the balance of a stiff rack."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics.gear import (
    column_balance,
    end_stop_torque,
    gear_coupling_torque,
    lash_torque,
    superposed_angle,
    tie_rod_force_of_balance,
)


def test_elastic_gear_works_without_loss():
    stiffness, ratio, motor, shaft, small = 7.26, 18.0, 0.5, 0.02, 1e-6

    def energy(motor, shaft):
        return 0.5 * stiffness * (motor - ratio * shaft) ** 2

    torque = gear_coupling_torque(motor, shaft, ratio, stiffness)
    assert torque == pytest.approx((energy(motor + small, shaft) - energy(motor - small, shaft)) / (2.0 * small))
    assert ratio * torque == pytest.approx(-(energy(motor, shaft + small) - energy(motor, shaft - small)) / (2 * small))


def test_either_input_alone_turns_the_pinion_by_its_ratio():
    assert superposed_angle(22.5, 0.0, 22.5, 1.0) == pytest.approx(1.0)
    assert superposed_angle(0.0, 1.0, 22.5, 1.1) == pytest.approx(1.0 / 1.1)
    assert superposed_angle(22.5, -1.0, 22.5, 1.0) == pytest.approx(0.0)


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


STOP = {"lock": 8.5, "stiffness": 400.0, "damping": 5.0}


def test_both_sides_push_back_beyond_the_lock_only():
    assert end_stop_torque(8.6, 0.0, **STOP) == pytest.approx(40.0)
    assert end_stop_torque(-8.6, 0.0, **STOP) == pytest.approx(-40.0)
    assert end_stop_torque(8.6, 1.0, **STOP) == pytest.approx(45.0)
    assert end_stop_torque(8.5, 3.0, **STOP) == 0.0
    assert end_stop_torque(-8.4, -3.0, **STOP) == 0.0


@given(st.floats(-12, 12), st.floats(-20, 20))
def test_a_stop_never_pulls(angle, rate):
    assert end_stop_torque(angle, rate, **STOP) * angle >= 0.0


RATIO = 1.0 / 146.12


def test_both_rows_of_the_two_bodies_add_up_without_the_force_of_the_teeth():
    random = np.random.default_rng(4)
    angle, rate, torque, force, teeth = random.normal(size=5)
    column = torque + RATIO * teeth
    rack = -teeth - force - 31227.0 * RATIO * angle - 22867.0 * RATIO * rate
    assert column_balance(torque, 0.0, force, angle, rate, RATIO, 31227.0, 22867.0) == pytest.approx(
        column + RATIO * rack
    )


def test_held_at_the_middle_a_newton_metre_holds_146_newtons():
    assert column_balance(1.0, 0.0, 146.12, 0.0, 0.0, RATIO, 31227.0, 22867.0) == pytest.approx(0.0, abs=1e-12)
    assert tie_rod_force_of_balance(1.5, 0.5, 403.2, 0.0, 0.2, 146.12) == pytest.approx(146.12)
    assert tie_rod_force_of_balance(0.5, 0.5, 400.0, 2.0, 0.2, 146.12) == pytest.approx(160.0)
