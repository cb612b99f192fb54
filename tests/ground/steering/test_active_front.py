from dataclasses import replace

import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.active_front import ActiveFront
from tierod_lab.ground.steering.column_eps import ColumnEps
from tierod_lab.ground.steering.shaft import Wheel

STEERING = replace(ActiveFront(), input_ratio=1.1)
LOADS = Loads(40.0, 50.0, 1.5, (3.0, 5.0), 9400.0, 15.0)


def moving(wheel, rate, motor, pinion, pinion_rate):
    motion = STEERING.init()
    column = motion.column._replace(angle=pinion, rate=pinion_rate, wheel=Wheel(wheel, rate))
    return motion._replace(column=column, motor_angle=motor)


def test_angles_superpose():
    """Reinelt et al., eq (1), with the turn of the shaft below the torsion bar."""
    motion = moving(0.50, 0.0, 6.0, 0.70, 0.0)
    signals = STEERING.signals(motion, STEERING.remembered(), LOADS)
    assert signals.pinion_angle == pytest.approx(motion.motor_angle / 22.5 + signals.truth_gear_input_angle / 1.1)
    twist = signals.steering_wheel_angle - signals.truth_gear_input_angle
    bar = STEERING.column.torsion_bar.stiffness / 1.1**2
    quiet = STEERING.signals(motion, STEERING.remembered(), LOADS._replace(actuator_torques=(3.0, 0.0)))
    assert quiet.driver_torque == pytest.approx(bar * twist)


def test_the_gear_loses_no_power():
    motion = moving(0.50, 0.9, 6.0, 0.70, 1.1)
    signals = STEERING.signals(motion, STEERING.remembered(), LOADS)
    at_pinion = 1.1 * signals.driver_torque
    load = STEERING.motor_load(signals, motion.motor_angle, 5.0, 0.0)
    assert load == pytest.approx(at_pinion / 22.5)
    into_the_gear = signals.driver_torque * 0.9 + load * 5.0
    bar = STEERING.column.torsion_bar
    twist_rate = 0.9 / 1.1 + 5.0 / 22.5 - 1.1
    assert into_the_gear - at_pinion * 1.1 == pytest.approx(at_pinion * twist_rate)
    elastic = at_pinion - bar.damping * twist_rate
    assert elastic == pytest.approx(bar.stiffness * (0.5 / 1.1 + 6.0 / 22.5 - 0.70))


def test_the_hands_feel_the_shaft():
    motion = moving(0.50, 0.9, 6.0, 0.70, 1.1)
    rates = STEERING.derivative(motion, motion, STEERING.remembered(), LOADS)
    signals = STEERING.signals(motion, STEERING.remembered(), LOADS)
    held = 1.5 - STEERING.column.wheel_damping * 0.9
    assert rates.column.wheel.rate == pytest.approx((held - signals.driver_torque) / STEERING.column.wheel_inertia)
    assert rates.column.wheel.angle == 0.9
    assert rates.motor_angle == 5.0


def test_without_motor_it_is_the_column():
    plain = ActiveFront()
    motion = plain.init()
    column = motion.column._replace(angle=0.2, rate=0.3, wheel=Wheel(0.21, 0.25))
    motion, loads = motion._replace(column=column), LOADS._replace(actuator_torques=(3.0, 0.0))
    own = plain.derivative(motion, motion, plain.remembered(), loads).column
    alone = plain.column.derivative(column, column, plain.remembered(), loads._replace(actuator_torques=(3.0,)))
    assert own == alone


def test_load_turns_on_with_wheel_and_pinion():
    signals = STEERING.signals(moving(0.5, 0.9, 6.0, 0.7, 1.1), STEERING.remembered(), LOADS)
    later = STEERING.signals(moving(0.5009, 0.9, 6.005, 0.7011, 1.1), STEERING.remembered(), LOADS)
    ahead = STEERING.motor_load(signals, 6.005, 5.0, 1e-3)
    assert ahead == pytest.approx(STEERING.motor_load(later, 6.005, 5.0, 0.0))


def test_a_column_without_torsion_bar_is_refused():
    with pytest.raises(ParameterError, match="torsion bar"):
        ActiveFront(column=ColumnEps(torsion_bar=None))
