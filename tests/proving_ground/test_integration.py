import math
from typing import NamedTuple

import pytest

from tierod.proving_ground.integration import runge_kutta


class Swing(NamedTuple):
    place: float
    speed: float


class Nested(NamedTuple):
    swing: Swing
    extra: tuple


def error(step):
    state = Nested(Swing(1.0, 0.0), ())
    for _ in range(round(1.0 / step)):
        state = runge_kutta(lambda s: Nested(Swing(s.swing.speed, -s.swing.place), ()), state, step)
    return abs(state.swing.place - math.cos(1.0))


def test_error_falls_with_the_fourth_power():
    assert error(0.1) / error(0.05) == pytest.approx(16.0, rel=0.1)
