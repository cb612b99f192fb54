"""Models of the column, the steering wheel and a steering by wire."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from models.friction_paper import CAR
from tierod.models.column_observation import linear_column, observed_column
from tierod.models.linear import LinearSystem, linearise
from tierod.models.steering_column import (
    Actuator,
    BelowBarParameters,
    ColumnParameters,
    FrictionParameters,
    SteeringColumn,
)
from tierod.vehicles import load
from tierod_lab.ground.steering.road_wheels import DisturbedSteering, SteerByWire

DT = 1e-3


@pytest.fixture(scope="module")
def known():
    return load("column-bench").parameters_for(ColumnParameters)


def test_it_moves_as_the_column_does(known):
    observed = observed_column(linear_column(SteeringColumn, known), DT, 2, 1)
    model, p = observed.model, observed.parameters
    x = model.State(0.3, -2.0, 0.1, 0.05, 1.0, 0.04, 1.5, 20.0, 0.2)
    u = model.Input(0.4)

    def slope(t, y):
        given = SteeringColumn.Input(0.4, 1.5 + 20.0 * t, 0.2)
        return SteeringColumn.derivative(SteeringColumn.State(*y), given, known)

    exact = solve_ivp(slope, (0.0, DT), x[:6], rtol=1e-11, atol=1e-13).y[:, -1]
    moved = model.transition(x, u, p)
    np.testing.assert_allclose(moved[:6], exact, rtol=1e-8)
    np.testing.assert_allclose(moved[6:], (1.52, 20.0, 0.2), rtol=1e-12)
    expected = SteeringColumn.output(SteeringColumn.State(*x[:6]), None, known)
    np.testing.assert_allclose(model.output(x, u, p), expected)


def system():
    rng = np.random.default_rng(0)
    return LinearSystem(
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 3)),
        ("x0", "x1"),
        ("known", "first", "second"),
        ("y0", "y1"),
    )


BY_WIRE = load("steer-by-wire").parameters_for(SteerByWire.Parameters)


def test_the_actuator_multiplies_along_the_way_from_the_current_to_the_road_wheels():
    actuator = load("steer-by-wire").parameters_for(Actuator)
    at_motor = actuator.motor_torque(2.0)
    assert at_motor == pytest.approx(0.06 * 2.0)
    assert actuator.road_wheel_torque(at_motor) == pytest.approx(17.0 * 3.0 * 0.06 * 75.0 * 0.7 * 2.0)


def test_it_settles_where_damping_and_friction_hold_the_torque():
    rate = 0.4
    p = BY_WIRE
    torque = p.road_wheel_damping * rate + p.road_wheel_friction * math.tanh(rate / p.friction_rate)
    after = SteerByWire.derivative(SteerByWire.State(0.1, rate), SteerByWire.Input(torque, 0.0), p)
    assert after == pytest.approx((rate, 0.0), abs=1e-12)


def test_the_disturbance_is_a_third_state_as_in_eq_18():
    p = dataclasses.replace(BY_WIRE, road_wheel_friction=0.0)
    system = linearise(DisturbedSteering, p, (0.0, 0.0, 0.0), (0.0,))
    inertia, damping = p.road_wheel_inertia, p.road_wheel_damping
    expected = [[0.0, 1.0, 0.0], [0.0, -damping / inertia, -1.0 / inertia], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(system.A, expected)
    np.testing.assert_allclose(system.B, [[0.0], [1.0 / inertia], [0.0]])
    np.testing.assert_allclose(system.C, [[1.0, 0.0, 0.0]])


def test_a_file_without_a_bar_means_a_rigid_one_and_all_below_it():
    assert CAR.below_bar == BelowBarParameters(CAR.column_inertia, CAR.column_damping, 0.0, 0.0, math.inf)
    assert math.isinf(load("rav4").parameters_for(FrictionParameters).torsion_bar_stiffness)
