import pytest

from tierod.physics.planar_motion import lateral_load_transfer, longitudinal_load_transfer


def test_links_alone_carry_the_moment_of_the_force_at_the_roll_centre():
    assert lateral_load_transfer(3000.0, 0.1, 0.0, 1.5) * 1.5 == pytest.approx(3000.0 * 0.1)


def test_springs_carry_their_roll_torque():
    assert lateral_load_transfer(0.0, 0.1, 900.0, 1.5) == pytest.approx(600.0)


def test_braking_loads_the_front_axle():
    assert longitudinal_load_transfer(-8000.0, 0.5, 2.5) == pytest.approx(-1600.0)
