"""The combined sideslip estimator beside the virtual car, and on what it must survive."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tierod.core.graph import scan
from tierod.models.lateral_motion import LateralParameters
from tierod.monitors.sideslip.estimator import CombinedSample, CombinedSideslip
from tierod.monitors.sideslip.tuning import CombinedTuning
from tierod.vehicles import load
from tierod_lab.ground import Sensor, SensorSet, run
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.courses.manoeuvres import RandomSteer

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

STEP = 0.01
RATE = 1.0 / STEP
NOISE = {
    "vehicle_speed": 0.02,
    "road_wheel_angle": 2e-4,
    "yaw_rate": 0.003,
    "lateral_acceleration": 0.1,
    "longitudinal_acceleration": 0.1,
    "road_wheel_torque": 1.0,
}
COLUMN = {name: k for k, name in enumerate(CombinedSample._fields)}


@pytest.fixture(scope="module")
def drive():
    """Random steering at 25 m/s: samples, true sideslip angle [rad]."""
    sensors = SensorSet({name: Sensor(noise=noise, rate=RATE) for name, noise in NOISE.items()})
    course = RandomSteer(speed=25.0, deviation=math.radians(14.0), lowest=0.1, highest=1.0, time=40.0, seed=7)
    recording = run(catalogue.load("steer-by-wire").block, course, seed=7, sensors=sensors).recording
    truth = recording["truth_sideslip_angle"]
    samples = np.column_stack([recording[name].values for name in CombinedSample._fields])
    return samples, np.interp(recording["yaw_rate"].time, truth.time, truth.values)


def estimator(steering=True, front=1.0, rear=1.0, **tuning):
    car = load("steer-by-wire").parameters_for(LateralParameters)
    wrong = dataclasses.replace(
        car,
        front_cornering_stiffness=front * car.front_cornering_stiffness,
        rear_cornering_stiffness=rear * car.rear_cornering_stiffness,
    )
    return CombinedSideslip.of_parameters(wrong, STEP, CombinedTuning(**tuning), steering)


def error(result, truth, start=20.0):
    """Root mean square error of the sideslip angle after a while [deg]."""
    return math.degrees(np.sqrt(np.mean((result["sideslip_angle"] - truth)[round(start / STEP) :] ** 2)))


@pytest.mark.parametrize("steering", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_wrong_stiffnesses_are_learnt(drive, steering):
    samples, truth = drive
    result = scan(estimator(steering, 1.2, 1.2), samples)
    assert error(result, truth) < 0.05
    assert result["front_stiffness"][-1] == pytest.approx(1.0 / 1.2, rel=0.05)
    assert result["rear_stiffness"][-1] == pytest.approx(1.0 / 1.2, rel=0.05)
    inside = np.abs(result["sideslip_angle"] - truth) < 1.96 * result["sideslip_angle_deviation"]
    assert np.mean(inside[2000:]) > 0.9


def gone(samples, first, last, **values):
    """The samples with some signals exchanged for a while."""
    changed = samples.copy()
    for name, value in values.items():
        changed[first:last, COLUMN[name]] = value
    return changed


@pytest.mark.parametrize(
    "values",
    [
        {"vehicle_speed": np.nan},
        {"vehicle_speed": 0.0},
        dict.fromkeys(CombinedSample._fields, np.nan),
    ],
)
@pytest.mark.parametrize("steering", [True, False])
def test_without_a_forward_speed_the_last_estimate_is_held_and_its_variance_grows(drive, values, steering):
    samples, truth = drive
    result = scan(estimator(steering), gone(samples, 1500, 1800, **values))
    assert np.isfinite(result.values).all()
    held = slice(1500, 1800)
    assert (result["held"][held] == 1.0).all()
    assert np.ptp(result["sideslip_angle"][held]) == 0.0
    growth = np.diff(result["sideslip_angle_deviation"][held])
    assert (growth >= 0.0).all()
    assert (growth[:150] > 0.0).all()
    assert result["held"][1800] == 0.0
    assert error(result, truth, 25.0) < 0.05
