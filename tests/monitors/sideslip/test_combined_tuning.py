"""Unknowns as first-order Gauss-Markov processes."""

from __future__ import annotations

import math

import pytest

from tierod.models.lateral_parameters import OF_STEERING
from tierod.monitors.sideslip.combined_tuning import (
    LATERAL_ACCELERATION,
    YAW_RATE,
    CombinedTuning,
    Wandering,
    tuning_of,
)
from tierod.vehicles import load


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


def test_sensors_of_a_production_car_have_offsets_and_a_file_that_names_one_is_believed():
    usual = tuning_of(load("midsize-eps"))
    assert usual.lateral_acceleration_bias == LATERAL_ACCELERATION
    assert usual.yaw_rate_bias == YAW_RATE
    assert tuning_of(load("steer-by-wire")).yaw_rate_bias is None
    named = load("revsted-car")
    assert tuning_of(named).lateral_acceleration_bias.deviation == named["lateral_acceleration_wander"]
    assert tuning_of(named).yaw_rate_bias is None
