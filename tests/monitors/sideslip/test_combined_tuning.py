"""Unknowns as first-order Gauss-Markov processes."""

from __future__ import annotations

import dataclasses
import math

import pytest

from tierod.models.lateral_parameters import OF_STEERING
from tierod.monitors.sideslip.tuning import (
    LATERAL_ACCELERATION,
    RATIO_ERROR,
    SLIP_ERROR,
    UNKNOWN_TYRES,
    YAW_ADAPTATION,
    YAW_RATE,
    CombinedTuning,
    Wandering,
    tuning_of,
)
from tierod.vehicles import load
from tierod_lab.papers.sideslip.calibration import with_parameters


def test_its_noise_keeps_the_deviation_of_the_long_run():
    wander = Wandering(0.3, 5.0)
    variance = 0.0
    for _ in range(10_000):
        variance = wander.fading(0.01) ** 2 * variance + wander.noise(0.01)
    assert math.sqrt(variance) == pytest.approx(0.3, rel=1e-3)
    assert wander.fading(5.0) == pytest.approx(math.exp(-1.0))


def test_unknowns_of_the_steering_are_followed_with_the_steering_alone():
    tuning = CombinedTuning()
    assert set(OF_STEERING) <= set(tuning.followed(True))
    assert not set(OF_STEERING) & set(tuning.followed(False))
    assert "bank_angle" not in CombinedTuning(bank_angle=None).followed(True)


def test_sensors_of_a_production_car_have_offsets_and_a_file_that_names_one_is_trusted():
    usual = tuning_of(load("midsize-eps"))
    assert usual.lateral_acceleration_bias == LATERAL_ACCELERATION
    assert usual.yaw_rate_bias == YAW_RATE
    assert tuning_of(load("steer-by-wire")).yaw_rate_bias is None
    named = load("revsted-car")
    assert tuning_of(named).lateral_acceleration_bias.deviation == named["lateral_acceleration_wander"]
    assert tuning_of(named).yaw_rate_bias is None


def test_noises_that_no_file_names_are_adapted_and_named_ones_trusted():
    usual = tuning_of(load("midsize-eps"))
    assert usual.yaw_adaptation == YAW_ADAPTATION
    assert usual.ratio_error == RATIO_ERROR
    assert usual.slip_error == SLIP_ERROR
    named = tuning_of(load("ferrari-250lm"))
    assert named.yaw_adaptation == named.acceleration_adaptation == named.ratio_error == named.slip_error == 0.0
    assert tuning_of(load("steer-by-wire")) == CombinedTuning()


def test_tyres_are_as_uncertain_as_the_file_says():
    car = load("midsize-eps")
    front = car.parameters["front_cornering_stiffness"]
    found = tuning_of(car).log_front_stiffness
    assert found.deviation == pytest.approx(front.standard_deviation / front.value)
    assert found.time == UNKNOWN_TYRES.time
    vague = dataclasses.replace(front, standard_deviation=None)
    without = dataclasses.replace(car, parameters={**car.parameters, front.name: vague})
    assert tuning_of(without).log_front_stiffness == UNKNOWN_TYRES
    sure = with_parameters(car, {front.name: 100.0 * front.value})
    assert tuning_of(sure).log_front_stiffness.deviation == 0.05
