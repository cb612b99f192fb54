"""Superposition and the demonstrator's steering against their published equations, linkage and motor."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering import Linkage, Motor, SpeedLimit, Wheel
from tierod_lab.ground.steering.column_eps import ActiveFront
from tierod_lab.ground.steering.friction import DryFriction
from tierod_lab.ground.steering.rack_eps import Demonstrator, demonstrator_rack

SUPERPOSED = replace(ActiveFront(), input_ratio=1.1)
SUPERPOSED_LOADS = Loads(40.0, 50.0, 1.5, (3.0, 5.0), 9400.0, 15.0)


def superposed_motion(wheel, rate, motor, pinion, pinion_rate):
    motion = SUPERPOSED.init()
    column = motion.column._replace(angle=pinion, rate=pinion_rate, wheel=Wheel(wheel, rate))
    return motion._replace(column=column, motor_angle=motor)


def test_the_gear_loses_no_power():
    motion = superposed_motion(0.50, 0.9, 6.0, 0.70, 1.1)
    signals = SUPERPOSED.signals(motion, SUPERPOSED.remembered(), SUPERPOSED_LOADS)
    at_pinion = 1.1 * signals.driver_torque
    load = SUPERPOSED.motor_load(signals, motion.motor_angle, 5.0, 0.0)
    assert load == pytest.approx(at_pinion / 22.5)
    into_the_gear = signals.driver_torque * 0.9 + load * 5.0
    bar = SUPERPOSED.column.torsion_bar
    twist_rate = 0.9 / 1.1 + 5.0 / 22.5 - 1.1
    assert into_the_gear - at_pinion * 1.1 == pytest.approx(at_pinion * twist_rate)
    elastic = at_pinion - bar.damping * twist_rate
    assert elastic == pytest.approx(bar.stiffness * (0.5 / 1.1 + 6.0 / 22.5 - 0.70))


SMOOTH = Demonstrator(rack=replace(demonstrator_rack(), friction=DryFriction(level=0.0)))
IDLE = Loads(0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0), 2000.0, 5.0)
PER_RACK = 1.0 / 146.12
"""Travel of the rack per turn of the column [m/rad]."""


@pytest.mark.parametrize("kingpin", [0.0, 30.0])
def test_torques_balance_at_rest(kingpin):
    """F = k_R S and what the kingpins pull, on the rack; M = g F on the column."""
    position = 0.01
    pull = kingpin * (1.0 / 19.7) / PER_RACK
    push = 31227.0 * position + pull
    torque = PER_RACK * push
    motion = SMOOTH.init()._replace(torque_1=0.7 * torque, torque_2=0.3 * torque)
    motion = motion._replace(rack=motion.rack._replace(angle=(position + push / 1e8) / PER_RACK, position=position))
    loads = IDLE._replace(
        kingpin_left=0.25 * kingpin, kingpin_right=0.75 * kingpin, actuator_torques=(0.7 * torque, 0.3 * torque, 1, 2)
    )
    rates = SMOOTH.derivative(motion, motion, SMOOTH.remembered(), loads)
    assert rates.rack.rate == pytest.approx(0.0, abs=1e-6)
    assert rates.rack.speed == pytest.approx(0.0, abs=1e-6)
    assert rates.torque_1 == rates.torque_2 == 0.0
    signals = SMOOTH.signals(motion, SMOOTH.remembered(), loads)
    assert signals.tie_rod_force == pytest.approx(pull)
    assert signals.tie_rod_force_right == pytest.approx(0.75 * pull)
    assert signals.steering_shaft_torque == pytest.approx(torque)
    assert (signals.drive_torque_left, signals.drive_torque_right) == (1, 2)
    steer = SMOOTH.steer(motion)
    assert 0.5 * (steer.left + steer.right) == pytest.approx(position / PER_RACK / 19.7)


GROWING = Linkage(ratio_growth=0.004)


def loads(left=0.0, right=0.0, front=9400.0):
    return Loads(left, right, 0.0, (0.0,), front, 10.0)


@given(st.floats(-8, 8), st.floats(-300, 300), st.floats(-300, 300))
def test_torque_at_the_pinion_does_the_work_of_the_kingpins(angle, left, right):
    resistance = GROWING.resistance(angle, 0.0, angle, GROWING.remembered(), loads(left, right))
    steer = GROWING.steer(angle, 1.0)
    assert resistance.kingpin == pytest.approx(left * steer.left_rate + right * steer.right_rate)
    assert resistance.left == pytest.approx(left * steer.left_rate)


def test_friction_of_the_kingpins_at_the_pinion():
    linkage = Linkage(friction=DryFriction(15.5, load_share=0.5))
    memory = linkage.advance(8.0, 1.0, 0.0, linkage.remembered(), loads())
    for front, expected in ((9400.0, 1.0), (4700.0, 0.75), (0.0, 0.5)):
        resistance = linkage.resistance(8.0, 1.0, 8.0, memory, loads(front=front))
        assert resistance.friction == pytest.approx(expected, rel=1e-3)
        assert resistance.left == resistance.right == 0.5 * resistance.friction
    assert linkage.friction_level(0.0) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("speed", "torque"), [(-300.0, 3.0), (0.0, 3.0), (150.0, 3.0), (250.0, 1.5), (350.0, 0.0), (500.0, 0.0)]
)
def test_torque_falls_between_base_and_no_load_speed(speed, torque):
    motor = Motor(lag=1.0, maximum_torque=3.0, speed_limit=SpeedLimit(150.0, 350.0))
    assert motor.torque_rate(0.0, 100.0, speed) == pytest.approx(torque)
    assert motor.torque_rate(0.0, -100.0, speed) == pytest.approx(-3.0 if speed >= -150.0 else -0.75)
