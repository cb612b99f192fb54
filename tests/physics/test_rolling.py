import pytest

from tierod.physics.rolling import holding_friction, rolling_resistance

MASS, TIME = 1600.0, 0.01


def test_resistance_is_a_share_of_the_load():
    assert rolling_resistance(15000.0, 0.01) == 150.0


def test_moving_is_resisted_by_the_greatest_friction_either_way():
    assert holding_friction(20.0, 0.0, 5000.0, MASS, TIME) == 5000.0
    assert holding_friction(-20.0, 0.0, 5000.0, MASS, TIME) == -5000.0


def test_at_rest_what_drives_is_held_exactly_up_to_the_greatest_friction():
    assert holding_friction(0.0, 3000.0, 5000.0, MASS, TIME) == 3000.0
    assert holding_friction(0.0, 8000.0, 5000.0, MASS, TIME) == 5000.0


def test_the_last_speed_fades_without_turning_round():
    speed = 0.5
    for _ in range(5000):
        after = speed + 1e-3 * (1000.0 - holding_friction(speed, 1000.0, 5000.0, MASS, TIME)) / MASS
        assert 0.0 <= after <= speed
        speed = after
    assert speed < 1e-9


def test_without_brake_nothing_is_held():
    assert holding_friction(3.0, 1000.0, 0.0, MASS, TIME) == 0.0
    assert holding_friction(3.0, -1000.0, 0.0, MASS, TIME) == pytest.approx(0.0)
