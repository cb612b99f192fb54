"""Steering: aligning torque, assist, gears and ratios."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import motion as single_track
from tierod.physics import steering as aligning
from tierod.physics.steering import (
    assist_torque,
    gear_coupling_torque,
    pinion_angle,
    road_wheel_angle,
    torsion_bar_torque,
    weight_lever,
    weight_torque,
)
from tierod_lab.papers.friction.joint_model import yaw_acceleration_from_aligning

MASS, INERTIA, FRONT, REAR, TRAIL = 1600.0, 2800.0, 1.14, 1.69, 0.05
FRONT_STIFFNESS, REAR_STIFFNESS, RATIO = 110e3, 130e3, 1.0 / 15.5
BODY = {"mass": MASS, "yaw_inertia": INERTIA, "front_distance": FRONT, "rear_distance": REAR}


def linear_axles(angle, sideslip, yaw_rate, speed):
    front = FRONT_STIFFNESS * (RATIO * angle - sideslip - FRONT * yaw_rate / speed)
    rear = REAR_STIFFNESS * (-sideslip + REAR * yaw_rate / speed)
    return front, rear


@given(st.floats(-1, 1), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5), st.floats(3, 60))
def test_force_and_yaw_acceleration_follow_from_each_other(angle, sideslip, yaw_rate, speed):
    front, rear = linear_axles(angle, sideslip, yaw_rate, speed)
    lateral = single_track.lateral_acceleration(front, rear, MASS)
    yaw_acceleration = single_track.yaw_acceleration(front, rear, INERTIA, FRONT, REAR)
    assert aligning.front_force_from_motion(lateral, yaw_acceleration, **BODY) == pytest.approx(front, abs=1e-5)
    again = yaw_acceleration_from_aligning(TRAIL * front, lateral, trail=TRAIL, **BODY)
    assert again == pytest.approx(yaw_acceleration, abs=1e-8)


@given(st.floats(-3e3, 3e3), st.floats(-5e3, 5e3), st.floats(-0.6, 0.6))
def test_the_force_across_the_wheels_is_what_makes_up_the_forces_of_the_axle(across, rolling, steer):
    body_across = across * math.cos(steer) + rolling * math.sin(steer)
    body_along = rolling * math.cos(steer) - across * math.sin(steer)
    assert aligning.force_across_wheels(body_across, body_along, steer) == pytest.approx(across, abs=1e-6)


SCRUB, INCLINATION, WHEEL_RADIUS = 0.02, 0.22, 0.31


def lift(steer):
    """How far the car rises, from turning a wheel's centre about the axis by Rodrigues' formula."""
    axis = np.array([0.0, -math.sin(INCLINATION), math.cos(INCLINATION)])
    centre = np.array([0.0, SCRUB, WHEEL_RADIUS])
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
    torque = weight_torque(load, weight_lever(SCRUB, INCLINATION, WHEEL_RADIUS), math.sin(steer))
    assert torque == pytest.approx(slope, rel=1e-6)


CHART = {"linear_gain": 2.0, "quadratic_gain": 1.5, "dead_band": 0.3, "half_speed": 15.0, "maximum_torque": 60.0}


@given(st.floats(-20, 20), st.floats(0, 60))
def test_assist_helps_the_driver_within_the_limit_and_is_odd(torque, speed):
    assist = assist_torque(torque, speed, **CHART)
    assert abs(assist) <= 60.0
    assert assist * torque >= 0.0
    assert assist_torque(-torque, speed, **CHART) == -assist


def test_assist_rises_with_torque_and_falls_with_speed():
    torques = np.linspace(0.0, 10.0, 200)
    assert np.all(np.diff(assist_torque(torques, 10.0, **CHART)) >= 0.0)
    assert assist_torque(3.0, 5.0, **CHART) > assist_torque(3.0, 30.0, **CHART)
    assert assist_torque(0.3, 0.0, **CHART) == 0.0
    assert assist_torque(10.0, 0.0, **CHART) == 60.0


def test_elastic_gear_works_without_loss():
    stiffness, ratio, motor, shaft, small = 7.26, 18.0, 0.5, 0.02, 1e-6

    def energy(motor, shaft):
        return 0.5 * stiffness * (motor - ratio * shaft) ** 2

    torque = gear_coupling_torque(motor, shaft, ratio, stiffness)
    assert torque == pytest.approx((energy(motor + small, shaft) - energy(motor - small, shaft)) / (2.0 * small))
    assert ratio * torque == pytest.approx(-(energy(motor, shaft + small) - energy(motor, shaft - small)) / (2 * small))


def test_bar_pulls_the_pinion_after_the_wheel():
    assert torsion_bar_torque(0.02, 0.0, 140.0) == pytest.approx(2.8)
    assert torsion_bar_torque(0.0, 0.0, 140.0, 1.0, 0.0, 0.05) == pytest.approx(0.05)


@pytest.mark.parametrize("growth", [-0.05, 0.0, 1e-13, 0.06, 0.4])
@pytest.mark.parametrize("angle", [-2.5, -0.3, 0.0, 1.0, 2.5])
def test_the_pinion_angle_is_the_root_of_the_cubic(angle, growth):
    steer = angle / 15.5 * (1.0 + growth / 3.0 * angle * angle)
    assert road_wheel_angle(angle, 1.0 / 15.5, growth) == pytest.approx(steer, abs=1e-12)
    assert pinion_angle(steer, 1.0 / 15.5, growth) == pytest.approx(angle, abs=1e-9)
    roots = np.roots([growth / 3.0, 0.0, 1.0, -15.5 * steer]) if growth else np.array([15.5 * steer])
    near = roots[np.argmin(np.abs(roots - angle))]
    assert pinion_angle(steer, 1.0 / 15.5, growth) == pytest.approx(near.real, abs=1e-9)
