import math

import numpy as np
import pytest

from tierod.physics.aligning import scrub_radius_torque, weight_lever, weight_torque

SCRUB, INCLINATION, RADIUS = 0.02, 0.22, 0.31


def lift(steer):
    """How far the car rises, from turning a wheel's centre about the axis by Rodrigues' formula."""
    axis = np.array([0.0, -math.sin(INCLINATION), math.cos(INCLINATION)])
    centre = np.array([0.0, SCRUB, RADIUS])
    turned = (
        centre * math.cos(steer)
        + np.cross(axis, centre) * math.sin(steer)
        + axis * (axis @ centre) * (1.0 - math.cos(steer))
    )
    return centre[2] - turned[2]


@pytest.mark.parametrize("steer", [-0.5, -0.1, 0.1, 0.3, 0.6])
def test_the_torque_is_the_slope_of_the_lifting_work(steer):
    load, small = 4500.0, 1e-5
    slope = load * (lift(steer + small) - lift(steer - small)) / (2.0 * small)
    torque = weight_torque(load, weight_lever(SCRUB, INCLINATION, RADIUS), math.sin(steer))
    assert torque == pytest.approx(slope, rel=1e-6)


def test_the_weight_turns_the_wheel_back():
    assert weight_torque(4500.0, weight_lever(SCRUB, INCLINATION, RADIUS), math.sin(0.3)) > 0.0


def test_an_upright_axis_lifts_nothing():
    assert weight_lever(SCRUB, 0.0, RADIUS) == 0.0


def test_equal_forces_do_not_steer_and_more_on_the_right_steers_left():
    left, right = scrub_radius_torque(500.0, 500.0, SCRUB)
    assert left + right == 0.0
    left, right = scrub_radius_torque(300.0, 700.0, SCRUB)
    assert left + right == pytest.approx(-SCRUB * 400.0)
