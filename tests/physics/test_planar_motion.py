"""Planar motion of a car: its accelerations, and following a path by aiming at a point ahead."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.physics.planar_motion import (
    central_speed,
    forward_rate,
    lateral_acceleration_of_turning,
    lateral_load_transfer,
    longitudinal_acceleration,
    longitudinal_load_transfer,
    pursuit_curvature,
    rear_wheel_share,
    rolling_curvature,
    rolling_road_wheel_angle,
    rolling_sideslip,
    rolling_yaw_rate,
)


def test_acceleration_is_the_second_derivative_of_the_path():
    step = 1e-4
    time = np.arange(-3, 4) * step
    speed, sideslip, heading = 8.0 + 2.0 * time, 0.1 + 0.3 * time, 0.5 + 0.6 * time
    velocity = np.stack([speed * np.cos(heading + sideslip), speed * np.sin(heading + sideslip)])
    ground = (velocity[:, 4] - velocity[:, 2]) / (2.0 * step)
    turn = math.cos(0.5), math.sin(0.5)
    body = turn[0] * ground[0] + turn[1] * ground[1], -turn[1] * ground[0] + turn[0] * ground[1]
    forward = speed * np.cos(sideslip)
    rate = (forward[4] - forward[2]) / (2.0 * step)
    assert longitudinal_acceleration(rate, forward[3], 0.1, 0.6) == pytest.approx(body[0], rel=1e-6)
    assert forward_rate(body[0], forward[3], 0.1, 0.6) == pytest.approx(rate, rel=1e-6)


def test_at_steady_speed_and_small_sideslip_the_lateral_acceleration_is_speed_times_course_rate():
    assert lateral_acceleration_of_turning(10.0, 0.3, 0.1) == pytest.approx(10.0 * 0.4, rel=1e-6)


@pytest.mark.parametrize("offset", [-0.5, 0.2])
def test_the_arc_meets_the_path_at_the_reach(offset):
    curvature = pursuit_curvature(offset, 20.0)
    assert offset + (1.0 - math.cos(20.0 * curvature)) / curvature == pytest.approx(0.0, abs=1e-3)


def test_links_alone_carry_the_moment_of_the_force_at_the_roll_centre():
    assert lateral_load_transfer(3000.0, 0.1, 0.0, 1.5) * 1.5 == pytest.approx(3000.0 * 0.1)


def test_springs_carry_their_roll_torque():
    assert lateral_load_transfer(0.0, 0.1, 900.0, 1.5) == pytest.approx(600.0)


def test_braking_loads_the_front_axle():
    assert longitudinal_load_transfer(-8000.0, 0.5, 2.5) == pytest.approx(-1600.0)


FRONT, REAR, TRACK = 0.904, 1.166, 1.084
WHEELBASE = FRONT + REAR


def circle(radius, yaw_rate=0.7):
    return yaw_rate, yaw_rate * (radius - TRACK / 2), yaw_rate * (radius + TRACK / 2)


@pytest.mark.parametrize("radius", [5.0, 20.0, -8.0])
def test_each_wheel_gives_the_angle_of_the_bicycle(radius):
    yaw, left, right = circle(radius, math.copysign(0.7, radius))
    expected = math.atan(WHEELBASE / radius)
    assert rolling_road_wheel_angle(yaw, left, TRACK / 2, WHEELBASE) == pytest.approx(expected, rel=1e-14)
    assert rolling_road_wheel_angle(yaw, right, -TRACK / 2, WHEELBASE) == pytest.approx(expected, rel=1e-14)


def test_the_printed_cotangents_say_the_same_away_from_straight_ahead():
    yaw, left, right = circle(12.0)
    printed = [
        math.atan(1.0 / (1.0 / math.tan(math.atan(yaw * WHEELBASE / v)) + way * TRACK / (2.0 * WHEELBASE)))
        for v, way in ((left, 1.0), (right, -1.0))
    ]
    assert printed == pytest.approx([math.atan(WHEELBASE / 12.0)] * 2, rel=1e-14)


def test_straight_ahead_and_standing_give_no_angle():
    assert rolling_road_wheel_angle(0.0, 10.0, 0.5, WHEELBASE) == 0.0
    assert rolling_road_wheel_angle(0.0, 0.0, 0.5, WHEELBASE) == 0.0
    assert math.isfinite(rolling_road_wheel_angle(0.3, -0.15, 0.5, WHEELBASE))


@pytest.mark.parametrize("radius", [5.0, 30.0, -6.0])
def test_central_speed_of_both_wheels_is_that_of_the_centre_of_gravity(radius):
    yaw, left, right = circle(radius, math.copysign(0.7, radius))
    steer = math.atan(WHEELBASE / radius)
    sideslip = rolling_sideslip(steer, REAR, WHEELBASE)
    curvature = rolling_curvature(steer, sideslip, WHEELBASE)
    expected = abs(yaw) * math.hypot(radius, REAR)
    for speed, lever in ((left, TRACK / 2), (right, -TRACK / 2)):
        assert central_speed(speed, rear_wheel_share(sideslip, curvature, lever)) == pytest.approx(expected, rel=1e-12)


def test_the_radicand_of_the_left_wheel_is_wrong_for_the_right_one():
    steer = math.atan(WHEELBASE / 5.0)
    sideslip = rolling_sideslip(steer, REAR, WHEELBASE)
    curvature = rolling_curvature(steer, sideslip, WHEELBASE)
    right = 6.0 * rear_wheel_share(sideslip, curvature, -TRACK / 2)
    assert central_speed(right, rear_wheel_share(sideslip, curvature, -TRACK / 2)) == pytest.approx(6.0)
    assert central_speed(right, rear_wheel_share(sideslip, curvature, TRACK / 2)) == pytest.approx(7.46, abs=0.005)


def test_the_share_is_the_root_of_the_printed_radicand():
    random = np.random.default_rng(1)
    for sideslip, curvature in random.uniform(-0.4, 0.4, (20, 2)):
        c = math.cos(sideslip)
        radicand = c * c + (TRACK / 2) ** 2 * curvature**2 - TRACK * curvature * c
        assert rear_wheel_share(sideslip, curvature, TRACK / 2) == pytest.approx(math.sqrt(radicand), rel=1e-12)


def test_yaw_rate_and_angle_are_inverse():
    yaw, left, right = circle(9.0)
    steer = rolling_road_wheel_angle(yaw, left, TRACK / 2, WHEELBASE)
    assert rolling_yaw_rate(steer, 0.5 * (left + right), WHEELBASE) == pytest.approx(yaw, rel=1e-12)
