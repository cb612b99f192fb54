"""aligning"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import aligning, single_track
from tierod.physics.aligning import scrub_radius_torque, weight_lever, weight_torque

MASS, INERTIA, FRONT, REAR, TRAIL = 1600.0, 2800.0, 1.14, 1.69, 0.05
FRONT_STIFFNESS, REAR_STIFFNESS, RATIO = 110e3, 130e3, 1.0 / 15.5
BODY = {"mass": MASS, "yaw_inertia": INERTIA, "front_distance": FRONT, "rear_distance": REAR}


def linear_axles(angle, sideslip, yaw_rate, speed):
    front = FRONT_STIFFNESS * (RATIO * angle - sideslip - FRONT * yaw_rate / speed)
    rear = REAR_STIFFNESS * (-sideslip + REAR * yaw_rate / speed)
    return front, rear


@given(st.floats(-1, 1), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5), st.floats(3, 60))
def test_three_roads_to_the_aligning_torque_meet(angle, sideslip, yaw_rate, speed):
    front, rear = linear_axles(angle, sideslip, yaw_rate, speed)
    lateral = single_track.lateral_acceleration(front, rear, MASS)
    yaw_acceleration = single_track.yaw_acceleration(front, rear, INERTIA, FRONT, REAR)
    from_steer = aligning.aligning_torque_from_steer(
        angle,
        lateral,
        yaw_rate,
        speed,
        mass=MASS,
        wheelbase=FRONT + REAR,
        front_stiffness=FRONT_STIFFNESS,
        rear_stiffness=REAR_STIFFNESS,
        trail=TRAIL,
        steering_ratio=RATIO,
    )
    from_yaw = aligning.aligning_torque_from_yaw(lateral, yaw_acceleration, trail=TRAIL, **BODY)
    assert from_steer == pytest.approx(TRAIL * front, abs=1e-6)
    assert from_yaw == pytest.approx(TRAIL * front, abs=1e-6)
    assert aligning.front_force_from_motion(lateral, yaw_acceleration, **BODY) == pytest.approx(front, abs=1e-5)
    again = aligning.yaw_acceleration_from_aligning(from_yaw, lateral, trail=TRAIL, **BODY)
    assert again == pytest.approx(yaw_acceleration, abs=1e-8)


@given(st.floats(-3e3, 3e3), st.floats(-5e3, 5e3), st.floats(-0.6, 0.6))
def test_the_force_across_the_wheels_is_what_makes_up_the_forces_of_the_axle(across, rolling, steer):
    body_across = across * math.cos(steer) + rolling * math.sin(steer)
    body_along = rolling * math.cos(steer) - across * math.sin(steer)
    assert aligning.force_across_wheels(body_across, body_along, steer) == pytest.approx(across, abs=1e-6)


def test_a_circle_at_constant_speed_pulls_the_centre_of_gravity_outward():
    radius, speed = 12.0, 5.0
    yaw_rate = speed / radius
    angle = yaw_rate * 1e-3 * np.arange(3)
    across = np.array([-np.sin(angle), np.cos(angle)])
    along = np.array([np.cos(angle), np.sin(angle)])
    path = -radius * across + REAR * along
    acceleration = (path[:, 2] - 2.0 * path[:, 1] + path[:, 0]) / 1e-6
    expected = MASS * float(acceleration @ along[:, 1])
    force = aligning.longitudinal_force_from_motion(0.0, yaw_rate, mass=MASS, rear_distance=REAR)
    assert force == pytest.approx(expected, rel=1e-3)
    assert aligning.longitudinal_force_from_motion(2.0, 0.0, mass=MASS, rear_distance=REAR) == 2.0 * MASS


def test_left_turn_gives_a_positive_torque_also_for_arrays():
    torque = aligning.aligning_torque_from_yaw(np.array([2.0, -2.0]), np.zeros(2), trail=TRAIL, **BODY)
    np.testing.assert_allclose(torque, [1.0, -1.0] * np.full(2, TRAIL * MASS * 2.0 * REAR / (FRONT + REAR)))


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
