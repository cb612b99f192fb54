"""Which signal has the wrong sign, from made-up turns."""

from __future__ import annotations

import numpy as np
import pytest

from tierod.monitors.sideslip.evidence import TOGETHER, SignsOverDrive


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
