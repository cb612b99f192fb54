"""The sampled lateral motion against closed forms of the single track, down to standstill."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.block import rebuild
from tierod.core.errors import ParameterError
from tierod.core.graph import jacobian
from tierod.models.lateral_motion import lateral_motion
from tierod.models.lateral_parameters import (
    LEAST_ACROSS,
    UNKNOWNS,
    AxleLoad,
    Driven,
    DrivenByWire,
    LateralParameters,
    Sampled,
    axle_force,
)
from tierod.physics.gravity import GRAVITY
from tierod.physics.magic_formula import magic_formula
from tierod.physics.single_track import understeer_gradient

CAR = LateralParameters(1640.0, 3500.0, 1.33, 1.31, 100e3, 140e3, pneumatic_trail=0.0)


def driven(model, car, inputs, seconds, step=0.01, start=None, count=0):
    p = Sampled(car, step, (0.0,) * count, (1.0,) * count)
    x = model.State(*(0.0 for _ in model.State._fields)) if start is None else start
    for _ in range(round(seconds / step)):
        x = model.transition(x, inputs, p)
    return x, model.output(x, inputs, p)


@pytest.mark.parametrize(
    ("step", "speed"),
    [(0.01, 5.0), (0.01, 25.0), (0.01, 40.0), (0.001, 40.0)]
    + [pytest.param(0.001, speed, marks=pytest.mark.slow) for speed in (5.0, 25.0)],
)
def test_it_turns_steadily_as_the_single_track(speed, step):
    steer = 0.002
    x, y = driven(lateral_motion(), CAR, Driven(speed, 0.0, steer), 6.0, step)
    gradient = understeer_gradient(CAR.mass, 1.33, 1.31, 100e3, 140e3)
    yaw_rate = speed * steer / (2.64 + gradient * speed * speed)
    assert y.yaw_rate == pytest.approx(yaw_rate, rel=2e-3)
    rear_slip = CAR.mass * speed * yaw_rate * 1.33 / 2.64 / 140e3
    assert x.lateral_speed == pytest.approx(1.31 * yaw_rate - speed * rear_slip, rel=5e-3, abs=1e-5)
    assert y.lateral_acceleration == pytest.approx(speed * yaw_rate * (1.0 + CAR.roll_share), rel=2e-3)


@pytest.mark.parametrize(
    ("step", "roll"),
    [(0.01, False), (0.01, True), (0.001, True), pytest.param(0.001, False, marks=pytest.mark.slow)],
)
def test_it_comes_to_the_motion_of_rolling_wheels_at_walking_pace(step, roll):
    x, y = driven(lateral_motion(roll=roll), CAR, Driven(0.6, 0.0, 0.4), 8.0, step)
    assert y.yaw_rate == pytest.approx(0.6 * math.tan(0.4) / 2.64, rel=0.02)
    assert x.lateral_speed == pytest.approx(1.31 * y.yaw_rate, rel=0.02)


def test_it_stays_finite_at_standstill():
    model = lateral_motion(roll=True)
    start = model.State(0.5, 0.3, 0.01, 0.01, 0.02, 0.1)
    x, _ = driven(model, CAR, Driven(0.0, 0.0, 0.3), 10.0, start=start)
    assert np.abs(x).max() < 2.0


def test_a_short_and_a_long_step_agree():
    inputs, model = Driven(25.0, 0.0, 0.02), lateral_motion(roll=True)
    coarse, fine = (driven(model, CAR, inputs, 0.3, step)[0] for step in (0.01, 0.001))
    np.testing.assert_allclose(coarse[:2], fine[:2], rtol=0.02)


def test_a_banked_road_is_felt_by_the_motion_and_not_by_the_sensor():
    model = lateral_motion(("bank_angle",))
    p = Sampled(CAR, 0.01, (0.0,), (1.0,))
    x = model.State(0.0, 0.0, 0.0, 0.0, 0.05)
    after = model.transition(x, Driven(25.0, 0.0, 0.0), p)
    assert after.lateral_speed == pytest.approx(-0.01 * GRAVITY * math.sin(0.05))
    assert model.output(x, Driven(25.0, 0.0, 0.0), p).lateral_acceleration == 0.0


def test_wind_is_felt_by_both():
    model = lateral_motion(("side_force", "side_moment"))
    p = Sampled(CAR, 0.01, (0.0, 0.0), (1.0, 1.0))
    x, u = model.State(0.0, 0.0, 0.0, 0.0, 820.0, 350.0), Driven(25.0, 0.0, 0.0)
    after = model.transition(x, u, p)
    assert after.yaw_rate == pytest.approx(0.01 * 350.0 / 3500.0)
    assert model.output(x, u, p).lateral_acceleration == pytest.approx(0.5 * (1.0 + CAR.roll_share))


def test_unknowns_return_to_what_is_usual():
    model = lateral_motion(("log_friction",))
    p = Sampled(CAR, 0.01, (0.2,), (math.exp(-0.01),))
    x = model.State(0.0, 0.0, 0.0, 0.0, 1.0)
    for _ in range(100):
        x = model.transition(x, Driven(10.0, 0.0, 0.0), p)
    assert x.log_friction == pytest.approx(0.2 + 0.8 * math.exp(-1.0))


def test_by_wire_the_torque_that_holds_a_turn_is_the_aligning_torque_and_the_friction():
    model, car = lateral_motion(steering=True), replace(CAR, pneumatic_trail=0.03)
    p = Sampled(car, 0.001)
    x = model.State(*(0.0 for _ in model.State._fields))
    for k in range(6000):
        torque = 60.0 * min(k / 3000.0, 1.0)
        x = model.transition(x, DrivenByWire(25.0, 0.0, torque, 1.0), p)
    held = DrivenByWire(25.0, 0.0, 60.0, 1.0)
    balance = model.forces(x, held, p).self_aligning_torque + 30.0 * x.friction_share
    assert balance == pytest.approx(60.0, abs=0.5)
    assert x.friction_share > 0.9


@pytest.mark.parametrize("step", [0.001, 0.01])
def test_by_wire_sliding_friction_has_its_level_and_adds_no_damping(step):
    model, car = lateral_motion(steering=True), replace(CAR, mechanical_trail=0.0)
    rate = -0.3
    torque = -car.road_wheel_friction + car.road_wheel_damping * rate
    x, _ = driven(model, car, DrivenByWire(10.0, 0.0, torque, 1.0), 0.3, step)
    assert x.friction_share == -1.0
    assert x.road_wheel_rate == pytest.approx(rate, rel=1e-4)


def test_by_wire_without_torque_the_road_wheels_keep_their_rate():
    model = lateral_motion(steering=True)
    x = model.State(0.0, 0.0, 0.0, 0.0, 0.01, 0.2, 0.0)
    after = model.transition(x, DrivenByWire(10.0, 0.0, 500.0, 0.0), Sampled(CAR, 0.01))
    assert after.road_wheel_rate == 0.2
    assert after.road_wheel_angle == pytest.approx(0.012)


def test_the_jacobian_of_the_whole_model_agrees_with_small_steps():
    model = lateral_motion(tuple(UNKNOWNS), roll=True, steering=True)
    count = len(UNKNOWNS)
    p = Sampled(CAR, 0.01, (0.0,) * count, (0.99,) * count)
    random = np.random.default_rng(4)
    centre = random.uniform(0.01, 0.1, len(model.State._fields))
    u = DrivenByWire(20.0, -1.0, 40.0, 1.0)
    x = rebuild(model.State(*centre), centre.tolist())
    exact = np.array(jacobian(lambda at: model.transition(at, u, p), x))
    for column in range(len(centre)):
        step = np.zeros(len(centre))
        step[column] = 1e-6
        ahead, behind = (
            np.array(model.transition(model.State(*(centre + sign * step).tolist()), u, p)) for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(exact[:, column], (ahead - behind) / 2e-6, rtol=1e-4, atol=1e-5)


def test_unknowns_that_the_model_does_not_have_are_refused():
    with pytest.raises(ParameterError, match="log_friction"):
        lateral_motion(("log_frictoin",))
    with pytest.raises(ParameterError, match="needs the steering"):
        lateral_motion(("log_trail",))


STIFFNESS, FRICTION, SHAPE, LOAD = 100e3, 0.9, 1.5, 8000.0


def force(slip, longitudinal=0.0, vertical=LOAD, friction=FRICTION, growth=0.6):
    return axle_force(slip, STIFFNESS, friction, SHAPE, AxleLoad(vertical, LOAD, longitudinal), growth)


@pytest.mark.parametrize("friction", [0.2, 0.9])
def test_its_slope_is_the_stiffness_whatever_the_friction(friction):
    assert force(1e-5, friction=friction).lateral / 1e-5 == pytest.approx(STIFFNESS, rel=1e-4)


def test_it_is_the_magic_formula_of_the_axle():
    expected = magic_formula(0.05, STIFFNESS / (SHAPE * FRICTION * LOAD), SHAPE, FRICTION * LOAD, 0.0)
    assert force(0.05).lateral == pytest.approx(expected)
    assert force(-0.05).lateral == pytest.approx(-expected)


def test_the_greatest_force_lies_on_the_ellipse():
    along = 0.6 * FRICTION * LOAD
    assert force(0.0, along).greatest == pytest.approx(0.8 * FRICTION * LOAD)
    slips = [0.001 * k for k in range(1, 800)]
    assert max(force(slip, along).lateral for slip in slips) == pytest.approx(0.8 * FRICTION * LOAD, rel=1e-3)


def test_locked_wheels_leave_a_little_to_steer_with():
    assert force(0.0, 2.0 * FRICTION * LOAD).greatest == pytest.approx(LEAST_ACROSS * FRICTION * LOAD)


def test_the_stiffness_grows_less_than_the_load():
    slope = force(1e-5, vertical=1.1 * LOAD).lateral / 1e-5
    assert slope == pytest.approx(1.06 * STIFFNESS, rel=1e-4)
    assert force(0.0, vertical=1.1 * LOAD).greatest == pytest.approx(1.1 * FRICTION * LOAD)


def test_the_angle_is_the_one_of_which_the_sine_is_taken():
    found = force(0.1)
    assert found.greatest * math.sin(SHAPE * found.angle) == pytest.approx(found.lateral)
