"""Vehicle and steering together against the matrices and eigenvalues that the equations give by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tierod.models.linear import linearise
from tierod.models.single_track import SingleTrack
from tierod.vehicles import load
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, TorqueShownVehicle, aligning_torque

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


def test_its_eigenvalues_at_the_speed_of_the_test():
    system = linearise(SteeredVehicle, FRICTIONLESS, (0.0,) * 4, (0.0, 6.7))
    found = np.sort_complex(np.linalg.eigvals(system.A))
    np.testing.assert_allclose(found, [-31.605 - 35.865j, -31.605 + 35.865j, -20.436, -1.699], atol=1e-3)
    vehicle = linearise(TorqueShownVehicle, VEHICLE.parameters_for(TorqueShownVehicle.Parameters), (0, 0), (0, 6.7))
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(vehicle.A)), [-19.815 - 0.659j, -19.815 + 0.659j], atol=1e-3
    )


def test_aligning_torque_and_yaw_rate_always_show_both_states():
    p = VEHICLE.parameters_for(TorqueShownVehicle.Parameters)
    system = linearise(TorqueShownVehicle, p, (0.0, 0.0), (0.0, 25.0))
    trail = p.mechanical_trail + p.pneumatic_trail
    stiffness = trail * p.front_cornering_stiffness
    np.testing.assert_allclose(system.C, [[0.0, 1.0], [-stiffness, -stiffness * p.front_distance / 25.0]])
    np.testing.assert_allclose(system.D[:, 0], [0.0, stiffness])
    assert np.linalg.det(system.C) == pytest.approx(stiffness)


def test_positive_steer_gives_an_aligning_torque_against_it():
    p = VEHICLE.parameters_for(TorqueShownVehicle.Parameters)
    torque = aligning_torque(SingleTrack.State(0.0, 0.0), SingleTrack.Input(0.01, 20.0), p)
    assert torque == pytest.approx(0.053 * 100e3 * 0.01)
