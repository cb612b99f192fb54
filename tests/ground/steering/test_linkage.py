import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.core.block import units
from tierod.core.signals import SIGNALS
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.linkage import EndStop, Linkage, SteeringSignals

GROWING = Linkage(ratio_growth=0.004)


def loads(left=0.0, right=0.0, front=9400.0):
    return Loads(left, right, 0.0, (0.0,), front, 10.0)


@given(st.floats(-8, 8), st.floats(-5, 5))
def test_rates_are_the_slopes_of_the_angles(angle, rate):
    step = 1e-6
    before, after = (GROWING.steer(angle + way * step, rate) for way in (-1.0, 1.0))
    here = GROWING.steer(angle, rate)
    assert here.left_rate == pytest.approx((after.left - before.left) / (2 * step) * rate, rel=1e-5, abs=1e-8)
    assert here.right_rate == pytest.approx((after.right - before.right) / (2 * step) * rate, rel=1e-5, abs=1e-8)


@given(st.floats(-8, 8), st.floats(-300, 300), st.floats(-300, 300))
def test_torque_at_the_pinion_does_the_work_of_the_kingpins(angle, left, right):
    resistance = GROWING.resistance(angle, 0.0, angle, GROWING.remembered(), loads(left, right))
    steer = GROWING.steer(angle, 1.0)
    assert resistance.kingpin == pytest.approx(left * steer.left_rate + right * steer.right_rate)
    assert resistance.left == pytest.approx(left * steer.left_rate)


def test_inner_wheel_steers_more():
    steer = Linkage().steer(6.0, 0.0)
    assert steer.left > steer.right > 0.0
    mirrored = Linkage().steer(-6.0, 0.0)
    assert (mirrored.left, mirrored.right) == pytest.approx((-steer.right, -steer.left))


def test_friction_of_the_kingpins_at_the_pinion():
    linkage = Linkage(friction=DryFriction(15.5, load_share=0.5))
    memory = linkage.advance(8.0, 1.0, 0.0, linkage.remembered(), loads())
    for front, expected in ((9400.0, 1.0), (4700.0, 0.75), (0.0, 0.5)):
        resistance = linkage.resistance(8.0, 1.0, 8.0, memory, loads(front=front))
        assert resistance.friction == pytest.approx(expected, rel=1e-3)
        assert resistance.left == resistance.right == 0.5 * resistance.friction
    assert linkage.friction_level(0.0) == pytest.approx(1.0)


def test_stops_act_beyond_the_lock():
    linkage = Linkage(end_stop=EndStop(5.0, 100.0, 0.0))
    for angle, torque in ((4.9, 0.0), (5.5, 50.0), (-5.5, -50.0)):
        assert linkage.resistance(angle, 0.0, angle, linkage.remembered(), loads()).stop == pytest.approx(torque)


FIELDS = list(zip(SteeringSignals._fields, units(SteeringSignals), strict=True))


@pytest.mark.parametrize(("name", "unit"), [field for field in FIELDS if not field[0].startswith("truth_")])
def test_signals_have_canonical_names_and_units(name, unit):
    assert SIGNALS[name].unit == unit
