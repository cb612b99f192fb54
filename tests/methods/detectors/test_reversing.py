"""Reversing of a car with unsigned speeds, from rolling wheels of a car that is placed step by step on the plane."""

import numpy as np
import pytest

from tierod.methods.detectors.reversing import Reversing

RATE, WHEELBASE, TRACK, RATIO = 50.0, 2.5, 1.5, 1.0 / 14.0
TIME = np.arange(0.0, 60.0, 1.0 / RATE)
SPEED = np.interp(TIME, [0, 5, 7, 10, 11, 14, 20, 40, 50, 60], [0, 0, -1.8, -1.8, 0, 0, 5, 12, 12, 4])
ANGLE = np.interp(TIME, [0, 4, 7, 10, 13, 22, 25, 30], [0, 0, 7, 6, 0, 1, -1, 0])


def moved(speed=SPEED, angle=ANGLE, seed=1):
    chance = np.random.default_rng(seed)
    yaw = speed * np.tan(RATIO * angle) / WHEELBASE
    left, right = (np.round(np.abs(speed + side * TRACK / 2 * yaw) / 0.02) * 0.02 for side in (-1.0, 1.0))
    return yaw + 0.004 * chance.standard_normal(len(TIME)), angle, np.abs(0.5 * (left + right)), right - left


def followed(*signals, cuts=1):
    made = Reversing(RATE, RATIO, WHEELBASE)
    pieces = zip(*(np.array_split(each, cuts) for each in (TIME, *signals)), strict=True)
    return made, np.concatenate([made.add(*piece) for piece in pieces])


@pytest.mark.parametrize("cuts", [1, 7, 400])
def test_a_car_that_backs_out_with_unsigned_speeds_is_recognised_until_it_stands(cuts):
    made, known = followed(*moved(), cuts=cuts)
    (found,) = made.found
    assert 5.0 < found.start < 5.5
    assert found.start < found.found < 7.5
    assert 10.5 < found.end <= 11.0
    assert made.turned_forward
    assert known[(TIME > 8.0) & (TIME < 10.5)].all()
    assert not known[TIME > 11.0].any()
    assert made.words == "the car reversed from 5.3 s to 10.8 s; its speeds have no sign"


def test_without_wheel_speeds_and_with_slow_sensors_it_is_recognised_as_well():
    yaw, angle, speed, _ = moved()
    angle = np.where(np.arange(len(TIME)) % 5 == 0, angle, np.nan)
    made = Reversing(RATE, RATIO, WHEELBASE)
    assert made.add(TIME, yaw, angle, speed).sum() > 3.0 * RATE


def test_signed_speeds_and_turns_forward_are_no_reversing_with_unsigned_ones():
    yaw, angle, speed, difference = moved()
    made, known = followed(yaw, angle, np.sign(SPEED) * speed, difference)
    assert not made.found
    assert not known[SPEED >= 0.0].any()
    forward = moved(np.abs(SPEED))
    assert not followed(*forward)[1].any()


def test_a_yaw_rate_of_the_wrong_sign_is_no_reversing_once_the_car_is_fast():
    yaw, angle, speed, difference = moved(np.abs(SPEED))
    made, known = followed(-yaw, angle, speed, difference)
    assert not known[TIME > 30.0].any()
    assert not made.turned_forward


def test_an_angle_of_the_wrong_sign_is_no_reversing():
    yaw, angle, speed, difference = moved(np.abs(SPEED))
    assert not followed(yaw, -angle, speed, difference)[1].any()


@pytest.mark.parametrize("offset", [-0.06, 0.06])
def test_an_offset_of_the_yaw_rate_is_no_reversing(offset):
    yaw, angle, speed, difference = moved(np.abs(SPEED), ANGLE * 0.05)
    assert not followed(yaw + offset, angle, speed, difference)[1].any()
