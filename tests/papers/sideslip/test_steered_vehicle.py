"""Vehicle and steering together against the matrices and eigenvalues that the equations give by hand."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tierod.models.linear import linearise
from tierod.vehicles import load
from tierod_lab.papers.sideslip.steered_vehicle import (
    Axles,
    Slips,
    SteeredVehicle,
)

VEHICLE = load("steer-by-wire")
FRICTIONLESS = dataclasses.replace(VEHICLE.parameters_for(SteeredVehicle.Parameters), road_wheel_friction=0.0)


def printed(p, speed):
    """A_3 of eq (13), entry by entry."""
    front, rear, a, b = (
        p.front_cornering_stiffness,
        p.rear_cornering_stiffness,
        p.front_distance,
        p.rear_distance,
    )
    c0, c1, c2 = front + rear, rear * b - front * a, front * a * a + rear * b * b
    c3 = (p.pneumatic_trail + p.mechanical_trail) * front
    m, i, j = p.mass, p.yaw_inertia, p.road_wheel_inertia
    return np.array(
        [
            [-c0 / (m * speed), -1.0 + c1 / (m * speed**2), front / (m * speed), 0.0],
            [c1 / i, -c2 / (i * speed), a * front / i, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [c3 / j, a * c3 / (j * speed), -c3 / j, -p.road_wheel_damping / j],
        ]
    )


@pytest.mark.parametrize("speed", [1.0, 6.7, 25.0])
def test_its_matrices_are_those_of_eq_13(speed):
    system = linearise(SteeredVehicle, FRICTIONLESS, (0.0,) * 4, (0.0, speed))
    np.testing.assert_allclose(system.A, printed(FRICTIONLESS, speed), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(system.B[:, 0], [0.0, 0.0, 0.0, 1.0 / FRICTIONLESS.road_wheel_inertia])
    np.testing.assert_allclose(system.C, [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


def test_tyres_follow_a_step_over_the_rolled_distance():
    axles = Axles(1.2, 1.4, 0.01, 0.0, 0.0, 0.0, front_relaxation=0.5, rear_relaxation=0.25)
    slips = Slips(0.0, 0.0, 0.0, 0.0)
    for _ in range(10):
        slips = axles.follow(slips, 0.0, 0.0, 0.03, 5.0, True)
    assert slips.front == pytest.approx(0.03)
    late = 0.03 * math.exp(-5.0 * 0.1 / 0.5)
    assert slips.front - slips.front_late == pytest.approx(late)
    assert math.sqrt(axles.variance(slips)) == pytest.approx(late)


def test_a_vehicle_file_shows_deviations_and_lengths():
    car = load("steer-by-wire")
    axles = Axles(1.33, 1.31, 0.01).of_vehicle(car)
    assert axles.front_stiffness_deviation == pytest.approx(0.1)
    assert axles.trail_deviation == pytest.approx(math.hypot(0.003, 0.006) / (0.023 + 0.03))
    assert axles.rear_relaxation == pytest.approx(car["relaxation_length"] * car["rear_relaxation_ratio"])
