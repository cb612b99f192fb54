"""Calibration and comparison with a truth on a small virtual truth: what the estimator itself says."""

import dataclasses
import math

import numpy as np
import pytest

from tierod.core.errors import InputError, ParameterError
from tierod.core.recording import Channel, Recording
from tierod.vehicles import load
from tierod_lab.papers.sideslip.calibration import BesideTruth, beside_truth, calibrated, with_parameters

pytestmark = pytest.mark.usefixtures("kernels_in_a_moment")

CAR = load("ferrari-250lm")
TIME = np.arange(3000) / 100.0


def drive(**more):
    rng = np.random.default_rng(4)
    steer = 0.05 * np.sin(0.9 * TIME)
    values = {
        "vehicle_speed": (np.full(len(TIME), 25.0), "m/s"),
        "road_wheel_angle": (steer, "rad"),
        "yaw_rate": (7.0 * steer + rng.normal(0.0, 0.003, len(TIME)), "rad/s"),
        "lateral_acceleration": (160.0 * steer + rng.normal(0.0, 0.5, len(TIME)), "m/s**2"),
        "longitudinal_acceleration": (np.zeros(len(TIME)), "m/s**2"),
    }
    channels = {name: Channel(name, TIME, value, unit) for name, (value, unit) in values.items()}
    return Recording(channels | {name: Channel(name, TIME, value, "rad") for name, value in more.items()})


def test_a_parameter_is_found_that_made_the_truth():
    name = "rear_cornering_stiffness"
    made = with_parameters(CAR, {name: 0.8 * CAR[name]})
    blank = drive(sideslip_angle=np.zeros(len(TIME)))
    truth = beside_truth(blank, made).estimate
    found = calibrated(drive(sideslip_angle=truth), CAR, (name,))
    assert abs(found[name] / made[name] - 1.0) < 0.5 * abs(CAR[name] / made[name] - 1.0)
    assert beside_truth(drive(sideslip_angle=truth), found).figures(1.0).rms < 0.5 * (
        beside_truth(drive(sideslip_angle=truth), CAR).figures(1.0).rms
    )


def test_a_parameter_without_a_standard_deviation_is_not_fitted():
    name = "rear_cornering_stiffness"
    vague = dataclasses.replace(CAR.parameters[name], standard_deviation=None)
    car = dataclasses.replace(CAR, parameters={**CAR.parameters, name: vague})
    with pytest.raises(ParameterError, match="no standard deviation of rear_cornering_stiffness"):
        calibrated(drive(sideslip_angle=np.zeros(len(TIME))), car, (name,))
    with pytest.raises(ParameterError, match="rear_cornering_stiffness"):
        with_parameters(CAR, {"rear_cornering_stifness": 1.0})


def test_without_a_truth_nothing_is_compared():
    with pytest.raises(InputError, match="name the true sideslip"):
        beside_truth(drive(), CAR)


def test_figures_of_an_error():
    time = np.arange(4.0)
    seen = BesideTruth(time, np.array([0.1, -0.1, 0.3, 9.0]), np.full(4, 0.1), np.array([0.0, 0.0, 0.0, np.nan]))
    found = seen.figures()
    assert found.mean_absolute == pytest.approx(0.5 / 3.0)
    assert found.rms == pytest.approx(math.sqrt(0.11 / 3.0))
    assert found.coverage == pytest.approx(2.0 / 3.0)
    with pytest.raises(InputError, match="no true sideslip from 3"):
        seen.figures(3.0)
