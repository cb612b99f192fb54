import pytest

from tierod.physics.aerodynamics import air_forces

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
