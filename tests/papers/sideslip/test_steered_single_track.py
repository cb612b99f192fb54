"""Equation (6) against SciPy's solver with the balance written out, and the closed form of a steady circle."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tierod.models.linear import discretise
from tierod.models.single_track import SingleTrack
from tierod.models.steer_by_wire import steering_acceleration
from tierod.vehicles import load
from tierod_lab.papers.sideslip.observer_datasets import steady
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle, TurnedSingleTrack, TurnedSteeredVehicle

M, IZ, A, B, CF, CR = 1640.0, 3500.0, 1.33, 1.31, 100e3, 140e3
CAR = SingleTrack.Parameters(M, IZ, A, B, CF, CR)
SPEED = 6.7


def slope(time, x):
    """Eqs (6) to (8), typed from the paper: m V (beta' + r) = Fyf cos d + Fyr, Iz r' = a Fyf cos d - b Fyr."""
    beta, r = x
    steer = 0.4 * math.sin(2.0 * time)
    front = -CF * (beta + A * r / SPEED - steer)
    rear = -CR * (beta - B * r / SPEED)
    across = front * math.cos(steer)
    return [(across + rear) / (M * SPEED) - r, (A * across - B * rear) / IZ]


def test_the_course_is_that_of_an_integrator():
    exact = solve_ivp(slope, (0.0, 1.5), (0.0, 0.0), rtol=1e-10, atol=1e-12).y[:, -1]
    model = discretise(TurnedSingleTrack, "rk4")
    x = SingleTrack.State(0.0, 0.0)
    for k in range(1500):
        inputs = SingleTrack.Input(0.4 * math.sin(2.0 * (k + 0.5) * 1e-3), SPEED)
        x = model.transition(x, inputs, model.Parameters(CAR, 1e-3))
    assert np.array(x) == pytest.approx(exact, rel=1e-4)
    plain = TurnedSingleTrack.output(SingleTrack.State(0.01, 0.2), SingleTrack.Input(0.0, SPEED), CAR)
    assert plain == SingleTrack.output(SingleTrack.State(0.01, 0.2), SingleTrack.Input(0.0, SPEED), CAR)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("angle", [-0.6, 0.1, 0.5])
def test_a_steady_circle_is_a_rest_of_the_model(angle, turned):
    found = steady(CAR, angle, SPEED, turned)
    model = TurnedSingleTrack if turned else SingleTrack
    rates = model.derivative(SingleTrack.State(*found), SingleTrack.Input(angle, SPEED), CAR)
    assert rates == pytest.approx((0.0, 0.0), abs=1e-9)


def test_the_steering_feels_the_force_across_the_wheels():
    p = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)
    x, u = SteeredVehicle.State(0.02, 0.3, 0.4, 0.1), SteeredVehicle.Input(50.0, SPEED)
    turned, plain = TurnedSteeredVehicle.derivative(x, u, p), SteeredVehicle.derivative(x, u, p)
    assert turned[2:] == plain[2:]
    front = p.front_cornering_stiffness * (0.4 - 0.02 - p.front_distance * 0.3 / SPEED)
    lost = front * (1.0 - math.cos(0.4))
    assert plain.yaw_rate - turned.yaw_rate == pytest.approx(p.front_distance * lost / p.yaw_inertia)
    torque = (p.mechanical_trail + p.pneumatic_trail) * front
    assert turned.road_wheel_rate == pytest.approx(steering_acceleration(0.1, 50.0, torque, p))
