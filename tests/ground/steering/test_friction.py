import math

import pytest

from tierod_lab.ground.steering.friction import Coulomb, DryFriction, LuGre, Wave


def sliding(friction, direction, angle=0.0, load=1.0):
    memory = friction.advance(friction.remembered(), direction * 3.0, direction * 2.0, load, angle)
    return friction.torque(memory, 0.0, direction * 2.0, load, angle)


@pytest.mark.parametrize("law", [Coulomb(), LuGre()])
def test_level_is_the_sliding_torque_at_the_reference_load(law):
    friction = DryFriction(5.0, law)
    assert sliding(friction, 1.0) == pytest.approx(5.0)
    assert sliding(friction, -1.0) == pytest.approx(-5.0)
    assert friction.sliding_level(0.3) == 5.0


def test_a_share_of_the_friction_follows_the_load():
    friction = DryFriction(5.0, load_share=0.4)
    assert sliding(friction, 1.0, load=1.0) == pytest.approx(5.0)
    assert sliding(friction, 1.0, load=3.0) == pytest.approx(5.0 * 1.8)
    assert sliding(friction, -1.0, load=-3.0) == pytest.approx(-5.0 * 1.8)
    assert sliding(friction, 1.0, load=0.0) == pytest.approx(3.0)


def test_one_side_may_rub_more():
    friction = DryFriction(4.0, left_excess=2.0)
    assert sliding(friction, 1.0) == pytest.approx(6.0)
    assert sliding(friction, -1.0) == pytest.approx(-4.0)
    assert friction.sliding_level(0.0) == 5.0


def test_a_bump_is_where_it_is_and_as_wide_as_said():
    friction = DryFriction(4.0, bump=3.0, bump_angle=1.0, bump_width=0.2)
    assert sliding(friction, 1.0, angle=1.0) == pytest.approx(7.0)
    assert friction.sliding_level(1.0) == 7.0
    assert 4.0 < sliding(friction, 1.0, angle=1.1) < 7.0
    assert sliding(friction, 1.0, angle=1.2) == pytest.approx(4.0)
    assert sliding(friction, 1.0, angle=-1.0) == pytest.approx(4.0)


def test_a_wave_comes_once_per_turn():
    friction = DryFriction(4.0, wave=Wave(1.0, 0.5))
    for turn in range(-1, 2):
        assert sliding(friction, 1.0, angle=0.5 + 2.0 * math.pi * turn) == pytest.approx(5.0)
        assert sliding(friction, 1.0, angle=0.5 + math.pi * (2.0 * turn + 1.0)) == pytest.approx(3.0)


def test_a_wave_above_the_level_leaves_no_friction():
    friction = DryFriction(1.0, wave=Wave(3.0))
    assert friction.sliding_level(0.0) == 4.0
    assert friction.sliding_level(math.pi) == sliding(friction, 1.0, angle=math.pi) == 0.0
