"""What the session says about wrong units and of an offset of the yaw rate, from a made-up drive."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.models.single_track import SingleTrack
from tierod.monitors.sideslip.sensors import SensorsOverDrive
from tierod.vehicles import load

RATE = 100.0
OFFSET = math.radians(1.7)


def seen(offset=0.0, stand=0.0, yaw=1.0, speed=1.0, acceleration=1.0, bank=0.0, angle=0.0, pieces=1, circle=0.0):
    p = load("steer-by-wire").parameters_for(SingleTrack.Parameters)
    time = np.arange(0.0, 40.0, 1.0 / RATE)
    v = np.where(time < stand, 0.0, 12.0)
    turn = np.where(time < stand, 0.0, circle + 0.15 * np.sin(2.0 * time))
    # Neutral steer is near enough for an offset of the angle, which the turn averages out.
    steer = turn * (p.front_distance + p.rear_distance) / 12.0 + angle
    sensors = SensorsOverDrive(p, RATE)
    for cut in np.array_split(np.arange(len(time)), pieces):
        sensors.add(speed * v[cut], yaw * turn[cut] + offset, acceleration * (v[cut] * turn[cut] + bank), steer[cut])
    return sensors


@pytest.mark.parametrize("stand", [0.0, 3.0])
def test_an_offset_is_reported_standing_and_driving(stand):
    found = seen(offset=OFFSET, stand=stand, pieces=3).offset()
    assert found.value == pytest.approx(OFFSET, rel=0.05)
    assert ("stands" in found.shown_by) == (stand > 0.0)


def test_neither_bank_nor_an_angle_that_is_off_is_taken_for_an_offset():
    assert seen(bank=0.5).offset() is None
    assert seen(angle=0.01).offset() is None
    assert seen().offset() is None


def test_an_acceleration_that_grows_with_speed_is_no_offset_of_the_yaw_rate_where_the_steering_fits_it():
    assert seen().offset(beside_turns=OFFSET) is None
    assert seen(offset=0.7 * OFFSET, bank=1.0).offset(beside_turns=OFFSET).value == OFFSET


def test_a_scale_is_not_taken_for_an_offset_in_turns_to_one_side():
    # Roll makes the acceleration read 5 % high, and tyres near their limit make the steering angle larger.
    assert seen(circle=0.3, acceleration=1.05, angle=0.01).offset() is None
    assert seen(circle=0.05, offset=OFFSET).offset().value == pytest.approx(OFFSET, rel=0.2)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"yaw": 57.3}, "degrees"),
        ({"yaw": 1.0 / 57.3}, "product of speed and yaw rate"),
        ({"speed": 3.6}, "product of speed and yaw rate"),
        ({"acceleration": 1.0 / 9.81}, "product of speed and yaw rate"),
    ],
)
def test_a_wrong_unit_is_reported(change, word):
    assert word in seen(**change, pieces=2).wrong_unit()


def test_right_units_are_not_doubted():
    assert seen(bank=0.3, offset=0.01).wrong_unit() is None


def given(*parts):
    """Sensors after parts of (seconds, speed, yaw rate, lateral acceleration): the steering shows the same offset."""
    sensors = SensorsOverDrive(load("steer-by-wire").parameters_for(SingleTrack.Parameters), RATE)
    for seconds, speed, yaw_rate, acceleration in parts:
        ones = np.ones(round(seconds * RATE))
        sensors.add(speed * ones, yaw_rate * ones, acceleration * ones, 0.0 * ones)
    return sensors


@pytest.mark.parametrize(("seconds", "shown"), [(0.98, False), (1.02, True)])
def test_a_stand_of_a_second_shows_the_offset_and_a_shorter_one_does_not(seconds, shown):
    assert (given((seconds, 0.0, OFFSET, 0.0)).offset() is not None) is shown


@pytest.mark.parametrize(("seconds", "shown"), [(9.9, False), (10.1, True)])
def test_ten_seconds_of_rolling_show_the_offset_and_fewer_do_not(seconds, shown):
    assert (given((seconds, 12.0, OFFSET, 0.0)).offset() is not None) is shown


@pytest.mark.parametrize(("speed", "shown"), [(4.9, False), (5.1, True)])
def test_a_car_rolls_from_five_metres_per_second_on(speed, shown):
    assert (given((20.0, speed, OFFSET, 0.0)).offset() is not None) is shown


@pytest.mark.parametrize(("yaw_rate", "wrong"), [(2.9, False), (3.1, True), (-3.1, True)])
def test_no_car_yaws_with_three_radians_per_second(yaw_rate, wrong):
    assert ("degrees" in (given((1.0, 1.0, yaw_rate, 0.0)).wrong_unit() or "")) is wrong


@pytest.mark.parametrize(("share", "wrong"), [(0.008, False), (0.012, True)])
def test_a_few_readings_beyond_are_no_wrong_unit(share, wrong):
    found = given((100.0 * share, 1.0, 4.0, 0.0), (100.0 * (1.0 - share), 1.0, 0.0, 0.0)).wrong_unit()
    assert ("degrees" in (found or "")) is wrong


def test_a_yaw_rate_that_is_not_still_shows_no_offset_while_the_car_stands():
    assert given((1.0, 0.0, OFFSET + 0.019, 0.0), (1.0, 0.0, OFFSET - 0.019, 0.0)).offset() is not None
    assert given((1.0, 0.0, OFFSET + 0.021, 0.0), (1.0, 0.0, OFFSET - 0.021, 0.0)).offset() is None
    assert given((2.0, 0.09, OFFSET, 0.0)).offset() is not None
    assert given((2.0, 0.11, OFFSET, 0.0)).offset() is None


@pytest.mark.parametrize(("ratio", "shown"), [(1.9, True), (2.1, False)])
def test_both_witnesses_must_show_the_same_within_a_factor_of_two(ratio, shown):
    """With the wheels straight the steering shows the whole yaw rate, the acceleration the rest of it."""
    acceleration = 12.0 * OFFSET * (1.0 - 1.0 / ratio)
    assert (given((20.0, 12.0, OFFSET, acceleration)).offset() is not None) is shown
