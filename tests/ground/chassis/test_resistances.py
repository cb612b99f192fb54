"""What resists a moving car: the air, rolling, and dry friction that holds what stands."""

import pytest

from tierod_lab.ground.chassis.resistances import air_forces, holding_friction, rolling_resistance

AREAS = (0.65, 5.0, 0.4)


def test_drag_grows_with_the_square_and_opposes_motion():
    slow, fast = air_forces(20.0, 0.0, *AREAS), air_forces(40.0, 0.0, *AREAS)
    assert slow.longitudinal == pytest.approx(-0.65 * 0.6 * 400.0)
    assert fast.longitudinal == pytest.approx(4.0 * slow.longitudinal)
    assert slow.lateral == slow.yaw_moment == 0.0
    assert air_forces(-20.0, 0.0, *AREAS).longitudinal == -slow.longitudinal


def test_wind_to_the_left_pushes_left_and_turns_the_nose_with_it():
    forces = air_forces(30.0, -10.0, *AREAS)
    assert forces.lateral == pytest.approx(5.0 * 0.6 * 1000.0**0.5 * 10.0)
    assert forces.yaw_moment == pytest.approx(0.4 * forces.lateral)


def test_still_air_does_nothing():
    assert tuple(air_forces(0.0, 0.0, *AREAS)) == (0.0, 0.0, 0.0)


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
