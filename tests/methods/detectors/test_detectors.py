"""Detectors as blocks: sums, debouncing, reversing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from example_models import assert_floats_equal_scan, with_gaps
from tierod.methods.detectors import Cusum, Debounce
from tierod.methods.detectors.reversing import Reversing

BLOCK = Cusum(drift=0.5, threshold=3.0, ceiling=6.0)


def page(values, drift, threshold, ceiling, sides, restart):
    up = down = 0.0
    rows = []
    for value in values:
        if np.isfinite(value):
            if sides != "lower":
                up = min(max(0.0, up + value - drift), ceiling)
            if sides != "upper":
                down = min(max(0.0, down - value - drift), ceiling)
        alarm = up >= threshold or down >= threshold
        rows.append([up, down, float(alarm)])
        if restart and alarm:
            up = down = 0.0
    return np.array(rows)


@pytest.mark.parametrize("restart", [False, True])
@pytest.mark.parametrize("sides", ["both", "upper", "lower"])
def test_agrees_with_page(sides, restart):
    rng = np.random.default_rng(0)
    values = with_gaps(rng, rng.normal(size=500) + np.repeat([0.0, 1.0, -1.0, 0.0, 2.0], 100))
    block = dataclasses.replace(BLOCK, sides=sides, restart=restart)
    result = assert_floats_equal_scan(block, values)
    np.testing.assert_allclose(result.values, page(values, 0.5, 3.0, 6.0, sides, restart), atol=1e-12)
    assert 0.0 < result["alarm"].mean() < 1.0


DEBOUNCE = Debounce(on_time=0.05, off_time=0.1, sample_time=0.01)


def test_debounce_agrees_with_counting():
    rng = np.random.default_rng(2)
    values = np.repeat(rng.integers(0, 2, 150), rng.integers(1, 20, 150)).astype(float)
    values[rng.random(len(values)) < 0.2] = np.nan
    result = assert_floats_equal_scan(DEBOUNCE, values)
    active, run, expected = 0, 0, []
    for value in values:
        if np.isfinite(value):
            run = run + 1 if value != active else 0
            if run == (10 if active else 5):
                active, run = 1 - active, 0
        expected.append(active)
    np.testing.assert_array_equal(result["active"], expected)
    assert 0.1 < np.mean(expected) < 0.9
    assert ((result["progress"] >= 0.0) & (result["progress"] <= 1.0)).all()


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


def test_signed_speeds_and_turns_forward_are_no_reversing_with_unsigned_ones():
    yaw, angle, speed, difference = moved()
    made, known = followed(yaw, angle, np.sign(SPEED) * speed, difference)
    assert not made.found
    assert not known[SPEED >= 0.0].any()
    forward = moved(np.abs(SPEED))
    assert not followed(*forward)[1].any()
