"""A steering without column against closed forms and the equations as the paper prints them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tierod.models.linear import linearise
from tierod.models.steer_by_wire import Actuator, DisturbedSteering, SteerByWire
from tierod.vehicles import load

PARAMETERS = load("steer-by-wire").parameters_for(SteerByWire.Parameters)


def test_the_actuator_multiplies_along_the_way_from_the_current_to_the_road_wheels():
    actuator = load("steer-by-wire").parameters_for(Actuator)
    at_motor = actuator.motor_torque(2.0)
    assert at_motor == pytest.approx(0.06 * 2.0)
    assert actuator.road_wheel_torque(at_motor) == pytest.approx(17.0 * 3.0 * 0.06 * 75.0 * 0.7 * 2.0)


def test_it_settles_where_damping_and_friction_hold_the_torque():
    rate = 0.4
    p = PARAMETERS
    torque = p.road_wheel_damping * rate + p.road_wheel_friction * math.tanh(rate / p.friction_rate)
    after = SteerByWire.derivative(SteerByWire.State(0.1, rate), SteerByWire.Input(torque, 0.0), p)
    assert after == pytest.approx((rate, 0.0), abs=1e-12)


def test_friction_opposes_motion_and_needs_none_at_rest():
    still = SteerByWire.derivative(SteerByWire.State(0.0, 0.0), SteerByWire.Input(0.0, 0.0), PARAMETERS)
    assert still == (0.0, 0.0)
    left, right = (
        SteerByWire.derivative(SteerByWire.State(0.0, rate), SteerByWire.Input(0.0, 0.0), PARAMETERS)
        for rate in (0.5, -0.5)
    )
    assert left.road_wheel_rate == -right.road_wheel_rate < 0.0


def test_the_disturbance_is_a_third_state_as_in_eq_18():
    p = dataclasses.replace(PARAMETERS, road_wheel_friction=0.0)
    system = linearise(DisturbedSteering, p, (0.0, 0.0, 0.0), (0.0,))
    inertia, damping = p.road_wheel_inertia, p.road_wheel_damping
    expected = [[0.0, 1.0, 0.0], [0.0, -damping / inertia, -1.0 / inertia], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(system.A, expected)
    np.testing.assert_allclose(system.B, [[0.0], [1.0 / inertia], [0.0]])
    np.testing.assert_allclose(system.C, [[1.0, 0.0, 0.0]])
