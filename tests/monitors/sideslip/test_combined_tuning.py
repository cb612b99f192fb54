"""Unknowns as first-order Gauss-Markov processes."""

from __future__ import annotations

import math

import pytest

from tierod.models.lateral_parameters import OF_STEERING
from tierod.monitors.sideslip.combined_tuning import CombinedTuning, Wandering


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
