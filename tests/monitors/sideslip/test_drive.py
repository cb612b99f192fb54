"""Which signal has the wrong sign, and which sideslip is the largest, from made-up turns."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.monitors.sideslip.drive import TOGETHER, EstimateFigures, SignsOverDrive


def found(turned=(), missing=(), speed=15.0):
    turn = np.sin(np.linspace(0.0, 20.0, 3000))
    noise = np.random.default_rng(0).normal(0.0, 0.2, (len(TOGETHER), len(turn)))
    signals = {name: turn + noise[k] for k, name in enumerate(TOGETHER)}
    signals |= {name: -signals[name] for name in turned}
    signals |= {name: np.full(len(turn), np.nan) for name in missing}
    signs = SignsOverDrive()
    signs.add(np.full(len(turn), speed), signals)
    return signs.turned()


def test_nothing_is_named_where_all_go_together():
    assert found() == ()


@pytest.mark.parametrize("name", TOGETHER)
def test_the_one_that_contradicts_the_others_is_named(name):
    assert found(turned=[name]) == (name,)


def test_of_two_signals_neither_can_be_cleared():
    rest = ("lateral acceleration", "steering torque")
    assert found(turned=["yaw rate"], missing=rest) == ("steering angle", "yaw rate")


def test_a_car_that_stands_shows_nothing():
    assert found(turned=["yaw rate"], speed=1.0) == ()


def test_the_largest_angle_is_the_one_that_is_surely_so_large_in_whatever_pieces():
    angle, deviation = np.array([0.0, 0.02, -0.037, 0.01]), np.array([0.003, 0.003, 0.038, 0.003])
    figures = EstimateFigures()
    for part in (slice(0, 1), slice(1, 2), slice(2, 4)):
        result = {"statement.magnitude": angle[part], "statement.deviation": deviation[part]}
        missing = np.full(len(angle[part]), np.nan)
        figures.add(np.ones(len(missing), bool), result, missing, missing, missing, missing)
    assert (figures.peak, figures.peak_deviation) == (0.02, 0.003)
