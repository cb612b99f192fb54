import pytest

from tierod.physics.torsion_bar import torsion_bar_torque, torsion_bar_twist


def test_bar_pulls_the_pinion_after_the_wheel():
    assert torsion_bar_torque(0.02, 0.0, 140.0) == pytest.approx(2.8)
    assert torsion_bar_torque(0.0, 0.0, 140.0, 1.0, 0.0, 0.05) == pytest.approx(0.05)


def test_twist_inverts_the_torque_at_rest():
    assert torsion_bar_twist(torsion_bar_torque(0.03, 0.01, 140.0), 140.0) == pytest.approx(0.02)
