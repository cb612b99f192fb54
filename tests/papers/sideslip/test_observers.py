"""Both observers on plants of their own making, at standstill, backwards, and without a signal."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.vehicles import load
from tierod_lab.papers.sideslip.observers import conventional_kalman, conventional_poles
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import two_stage_kalman, two_stage_poles

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

CAR = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)
DT = 0.01
OBSERVERS = {
    "conventional, Kalman": conventional_kalman,
    "conventional, poles": conventional_poles,
    "two-stage, Kalman": two_stage_kalman,
    "two-stage, poles": two_stage_poles,
}


@pytest.fixture(scope="module", params=list(OBSERVERS))
def observer(request):
    return OBSERVERS[request.param](CAR, DT)


def settled(speed, steer=0.02):
    p, wheelbase = CAR, CAR.front_distance + CAR.rear_distance
    front, rear = p.front_cornering_stiffness, p.rear_cornering_stiffness
    gradient = p.mass / wheelbase * (p.rear_distance / front - p.front_distance / rear)
    yaw_rate = speed * steer / (wheelbase + gradient * speed**2)
    rear_force = p.mass * speed * yaw_rate * p.front_distance / wheelbase
    front_force = p.mass * speed * yaw_rate * p.rear_distance / wheelbase
    sideslip = p.rear_distance * yaw_rate / speed - rear_force / rear
    return yaw_rate, sideslip, (p.mechanical_trail + p.pneumatic_trail) * front_force


def turning(speed, count=600, steer=0.02):
    yaw_rate, sideslip, torque = settled(speed, steer)
    return np.tile([speed, yaw_rate, steer, torque], (count, 1)), sideslip, torque


@pytest.mark.parametrize("speed", [2.0, 25.0])
def test_in_a_steady_turn_they_find_sideslip_and_torque_exactly(observer, speed):
    samples, sideslip, torque = turning(speed)
    result = scan(observer, samples)
    assert result["sideslip_angle"][-1] == pytest.approx(sideslip, abs=2e-5)
    assert result["self_aligning_torque"][-1] == pytest.approx(torque, rel=2e-3)
    assert result["estimated_yaw_rate"][-1] == pytest.approx(samples[0, 1], rel=1e-3)


def test_they_run_from_standstill_to_the_highest_speed_and_back_without_a_leap(observer):
    speed = np.concatenate([np.zeros(50), np.linspace(0.0, 70.0, 2000), np.linspace(70.0, -1.0, 2000)])
    rows = [[v, *settled(max(v, 0.01), 0.005)[:1], 0.005, settled(max(v, 0.01), 0.005)[2]] for v in speed]
    result = scan(observer, np.array(rows))
    assert np.isfinite(result.values).all()
    leaps = np.abs(np.diff(result["sideslip_angle"]))
    assert leaps.max() <= 0.005 * CAR.rear_distance / (CAR.front_distance + CAR.rear_distance)
    assert leaps[70:].max() < 1e-3
    truth = np.array([settled(v, 0.005)[1] if v > 1.5 else np.nan for v in speed])
    assert np.nanmax(np.abs(result["sideslip_angle"] - truth)) < 1e-3


@pytest.mark.parametrize("how", ["stand", "backwards", "no torque", "nothing"])
def test_where_nothing_is_identifiable_the_last_estimate_is_held_and_its_variance_grows(observer, how):
    samples, sideslip, _ = turning(10.0)
    rest = samples.copy()
    rest[:, 0] = {"stand": 0.0, "backwards": -3.0}.get(how, 10.0)
    if how == "no torque":
        rest[:, 3] = np.nan
    if how == "nothing":
        rest[:] = np.nan
    result = scan(observer, np.vstack([samples, rest, samples]))
    held = slice(600, 1200)
    assert (result["held"][held] == 1.0).all()
    assert (result["sideslip_angle"][held] == result["sideslip_angle"][599]).all()
    assert (np.diff(result["sideslip_angle_deviation"][held]) > 0.0).all()
    assert np.isfinite(result.values).all()
    assert result["sideslip_angle"][-1] == pytest.approx(sideslip, abs=1e-4)
    assert result["sideslip_angle_deviation"][-1] < 1.05 * result["sideslip_angle_deviation"][599]


@pytest.mark.parametrize("column", [1, 2])
def test_a_missing_measurement_leaves_them_running(observer, column):
    samples, _, _ = turning(15.0)
    samples[300:350, column] = np.nan
    result = scan(observer, samples)
    assert np.isfinite(result.values).all()
    assert (result["held"] == 0.0).all()
    assert (result["readings"][300:350] < 2.0).all()


@pytest.mark.parametrize("build", OBSERVERS.values(), ids=list(OBSERVERS))
def test_a_car_that_cannot_be_followed_is_refused_with_the_reason(build):
    with pytest.raises(ParameterError, match="does not depend on sideslip_angle"):
        build(dataclasses.replace(CAR, mechanical_trail=-CAR.pneumatic_trail), DT)
    with pytest.raises(ParameterError, match=r"eigenvalue of -\d+"):
        build(dataclasses.replace(CAR, road_wheel_friction=900.0, road_wheel_inertia=1.0), DT)
    with pytest.raises(ParameterError, match="sample time"):
        build(CAR, 0.0)
