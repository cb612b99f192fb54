"""Lateral force of an axle: slope, peak, ellipse, load."""

from __future__ import annotations

import math

import pytest

from tierod.models.lateral_parameters import LEAST_ACROSS, AxleLoad, axle_force
from tierod.physics.magic_formula import magic_formula

STIFFNESS, FRICTION, SHAPE, LOAD = 100e3, 0.9, 1.5, 8000.0


def force(slip, longitudinal=0.0, vertical=LOAD, friction=FRICTION, growth=0.6):
    return axle_force(slip, STIFFNESS, friction, SHAPE, AxleLoad(vertical, LOAD, longitudinal), growth)


@pytest.mark.parametrize("friction", [0.2, 0.9])
def test_its_slope_is_the_stiffness_whatever_the_friction(friction):
    assert force(1e-5, friction=friction).lateral / 1e-5 == pytest.approx(STIFFNESS, rel=1e-4)


def test_it_is_the_magic_formula_of_the_axle():
    expected = magic_formula(0.05, STIFFNESS / (SHAPE * FRICTION * LOAD), SHAPE, FRICTION * LOAD, 0.0)
    assert force(0.05).lateral == pytest.approx(expected)
    assert force(-0.05).lateral == pytest.approx(-expected)


def test_the_greatest_force_lies_on_the_ellipse():
    along = 0.6 * FRICTION * LOAD
    assert force(0.0, along).greatest == pytest.approx(0.8 * FRICTION * LOAD)
    slips = [0.001 * k for k in range(1, 800)]
    assert max(force(slip, along).lateral for slip in slips) == pytest.approx(0.8 * FRICTION * LOAD, rel=1e-3)


def test_locked_wheels_leave_a_little_to_steer_with():
    assert force(0.0, 2.0 * FRICTION * LOAD).greatest == pytest.approx(LEAST_ACROSS * FRICTION * LOAD)


def test_the_stiffness_grows_less_than_the_load():
    slope = force(1e-5, vertical=1.1 * LOAD).lateral / 1e-5
    assert slope == pytest.approx(1.06 * STIFFNESS, rel=1e-4)
    assert force(0.0, vertical=1.1 * LOAD).greatest == pytest.approx(1.1 * FRICTION * LOAD)


def test_the_angle_is_the_one_of_which_the_sine_is_taken():
    found = force(0.1)
    assert found.greatest * math.sin(SHAPE * found.angle) == pytest.approx(found.lateral)
