"""Planar motion of a car: its accelerations, and following a path by aiming at a point ahead."""

import math

import numpy as np
import pytest

from tierod.physics.planar_motion import (
    forward_rate,
    lateral_acceleration_of_turning,
    longitudinal_acceleration,
    pursuit_curvature,
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
