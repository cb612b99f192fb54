from dataclasses import replace

import pytest

from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.linkage import Linkage
from tierod_lab.ground.steering.steer_by_wire import HandWheelMotion, SteerByWire

PLAIN = SteerByWire()
STEERING = replace(PLAIN, linkage=replace(PLAIN.linkage, ackermann_gain=0.0))
"""Both road wheels turn alike, as in the paper."""
LOADS = Loads(60.0, 90.0, 0.5, (0.4, -1.0), 9400.0, 10.0)


def moving(rate=0.0, torque=0.0):
    return STEERING.init()._replace(
        angle=17.0 * 0.05, rate=17.0 * rate, motor_torque=torque, wheel=HandWheelMotion(0.8, 0.2, -0.9)
    )


@pytest.mark.parametrize(("rate", "torque"), [(0.0, 0.3), (0.2, -0.1)])
def test_it_obeys_equation_1(rate, torque):
    """J_w 3.5 kg m2, b_w 160 Nms/rad, F_w 30 Nm, r_s 17, r_p 3, r_g 75, eta 0.7, k_M 0.06 Nm/A."""
    memory = STEERING.remembered()._replace(road_wheels=1.0)
    motion = moving(rate, torque)
    signals = STEERING.signals(motion, memory, LOADS)
    driving = 17.0 * 3.0 * 75.0 * 0.7 * torque
    assert signals.road_wheel_torque == pytest.approx(driving)
    assert signals.truth_road_wheel_friction == pytest.approx(30.0, rel=1e-9)
    expected = (driving - 160.0 * rate - 30.0 - 150.0) / 3.5
    assert signals.truth_road_wheel_acceleration == pytest.approx(expected, rel=1e-3)
    assert signals.motor_current == pytest.approx(torque / 0.06)
    assert signals.road_wheel_angle == pytest.approx(0.05)
    assert signals.road_wheel_rate == pytest.approx(rate)


def test_the_hands_feel_the_feedback_motor_alone():
    motion, memory = moving(), STEERING.remembered()
    rates = STEERING.derivative(motion, motion, memory, LOADS)
    unit = STEERING.hand_wheel
    left = 0.5 - 0.9 - unit.damping * 0.2
    assert rates.wheel.rate == pytest.approx(left / (unit.inertia + STEERING.feedback.inertia))
    away = LOADS._replace(kingpin_left=900.0)
    assert STEERING.derivative(motion, motion, memory, away).wheel == rates.wheel


def test_the_sensor_of_the_hands_sits_above_the_feedback_motor():
    motion, memory = moving(), STEERING.remembered()
    signals, rates = STEERING.signals(motion, memory, LOADS), STEERING.derivative(motion, motion, memory, LOADS)
    assert signals.driver_torque == pytest.approx(0.5 - STEERING.hand_wheel.inertia * rates.wheel.rate)


def test_the_friction_of_the_road_wheels_is_that_of_the_linkage():
    assert isinstance(STEERING.linkage, Linkage)
    signals = STEERING.signals(moving(), STEERING.remembered(), LOADS)
    assert signals.truth_road_wheel_friction == 0.0
    assert signals.truth_road_wheel_friction_level == pytest.approx(30.0, rel=1e-3)
