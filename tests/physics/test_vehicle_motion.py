"""Motion of a car: single track, planar motion, rolling wheels."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import motion as single_track
from tierod.physics.motion import lateral_acceleration_of_turning, longitudinal_acceleration
from tierod.physics.tyre import linear_lateral_force
from tierod_lab.ground.laws import steady_road_wheel_angle


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


def test_at_steady_speed_and_small_sideslip_the_lateral_acceleration_is_speed_times_course_rate():
    assert lateral_acceleration_of_turning(10.0, 0.3, 0.1) == pytest.approx(10.0 * 0.4, rel=1e-6)


def test_a_point_of_the_body_is_accelerated_as_on_its_path():
    step, forward, left, rate, growth = 1e-4, 1.3, 0.4, 0.7, 0.9
    turned = rate * np.array([-step, 0.0, step]) + 0.5 * growth * step * step * np.array([1.0, 0.0, 1.0])
    across = forward * np.sin(turned) + left * np.cos(turned)
    found = single_track.lateral_acceleration_at(0.0, growth, rate, forward, left)
    assert found == pytest.approx((across[0] - 2.0 * across[1] + across[2]) / step**2, rel=1e-4)


MASS, TO_FRONT, TO_REAR, FRONT_STIFFNESS, REAR_STIFFNESS = 1600.0, 1.14, 1.69, 110e3, 130e3
GRADIENT = single_track.understeer_gradient(MASS, TO_FRONT, TO_REAR, FRONT_STIFFNESS, REAR_STIFFNESS)


@given(st.floats(2.0, 60.0), st.floats(-0.02, 0.02))
def test_steady_turn_balances_forces_and_moments(speed, curvature):
    steer = steady_road_wheel_angle(curvature, speed, TO_FRONT + TO_REAR, GRADIENT)
    yaw_rate = speed * curvature
    rear_force = MASS * speed * yaw_rate * TO_FRONT / (TO_FRONT + TO_REAR)
    lateral_speed = TO_REAR * yaw_rate - speed * rear_force / REAR_STIFFNESS
    front_slip = single_track.front_slip_speed(lateral_speed, yaw_rate, speed, steer, TO_FRONT) / speed
    rear_slip = single_track.rear_slip_speed(lateral_speed, yaw_rate, TO_REAR) / speed
    front = linear_lateral_force(front_slip, FRONT_STIFFNESS)
    rear = linear_lateral_force(rear_slip, REAR_STIFFNESS)
    assert single_track.yaw_acceleration(front, rear, 2800.0, TO_FRONT, TO_REAR) == pytest.approx(0.0, abs=1e-6)
    assert single_track.lateral_acceleration(front, rear, MASS) == pytest.approx(speed * yaw_rate, abs=1e-6)
    gain = single_track.steady_yaw_gain(speed, TO_FRONT + TO_REAR, GRADIENT)
    assert gain * steer == pytest.approx(yaw_rate, abs=1e-9)
