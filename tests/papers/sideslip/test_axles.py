"""What stiffness, trail and late tyres make of the sideslip angle, beside closed forms."""

from __future__ import annotations

import math

import pytest

from tierod.vehicles import load
from tierod_lab.papers.sideslip.axles import TORQUE_SHARE, Axles, Slips


def test_errors_that_know_nothing_of_each_other_add_by_their_squares():
    axles = Axles(1.2, 1.4, 0.01, 0.1, 0.2, 0.3)
    steady = Slips(0.02, 0.01, 0.02, 0.01)
    expected = math.hypot(0.1 * 0.02, 0.2 * 0.01, TORQUE_SHARE * 0.3 * 0.02)
    assert math.sqrt(axles.variance(steady)) == pytest.approx(expected)


def test_tyres_follow_a_step_over_the_rolled_distance():
    axles = Axles(1.2, 1.4, 0.01, 0.0, 0.0, 0.0, front_relaxation=0.5, rear_relaxation=0.25)
    slips = axles.start()
    for _ in range(10):
        slips = axles.follow(slips, 0.0, 0.0, 0.03, 5.0, True)
    assert slips.front == pytest.approx(0.03)
    late = 0.03 * math.exp(-5.0 * 0.1 / 0.5)
    assert slips.front - slips.front_late == pytest.approx(late)
    assert math.sqrt(axles.variance(slips)) == pytest.approx(late)


def test_the_rear_axle_slips_as_the_car_turns():
    slips = Axles(1.2, 1.4, 0.01).follow(Axles.start(), -0.01, 0.2, 0.0, 20.0, True)
    assert slips.rear == pytest.approx(1.4 * 0.2 / 20.0 + 0.01)


def test_a_vehicle_file_shows_deviations_and_lengths():
    car = load("steer-by-wire")
    axles = Axles(1.33, 1.31, 0.01).of_vehicle(car)
    assert axles.front_stiffness_deviation == pytest.approx(0.1)
    assert axles.trail_deviation == pytest.approx(math.hypot(0.003, 0.006) / (0.023 + 0.03))
    assert axles.rear_relaxation == pytest.approx(car["relaxation_length"] * car["rear_relaxation_ratio"])
