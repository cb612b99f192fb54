import numpy as np
import pytest

from tierod.physics.rack_balance import column_balance, tie_rod_force_of_balance

RATIO = 1.0 / 146.12


def test_both_rows_of_the_two_bodies_add_up_without_the_force_of_the_teeth():
    random = np.random.default_rng(4)
    angle, rate, torque, force, teeth = random.normal(size=5)
    column = torque + RATIO * teeth
    rack = -teeth - force - 31227.0 * RATIO * angle - 22867.0 * RATIO * rate
    assert column_balance(torque, 0.0, force, angle, rate, RATIO, 31227.0, 22867.0) == pytest.approx(
        column + RATIO * rack
    )


def test_held_at_the_middle_a_newton_metre_holds_146_newtons():
    assert column_balance(1.0, 0.0, 146.12, 0.0, 0.0, RATIO, 31227.0, 22867.0) == pytest.approx(0.0, abs=1e-12)
    assert tie_rod_force_of_balance(1.5, 0.5, 403.2, 0.0, 0.2, 146.12) == pytest.approx(146.12)
    assert tie_rod_force_of_balance(0.5, 0.5, 400.0, 2.0, 0.2, 146.12) == pytest.approx(160.0)
