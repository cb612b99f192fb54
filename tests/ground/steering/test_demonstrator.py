from dataclasses import replace

import numpy as np
import pytest

from tierod.core.graph.derivatives import jacobian
from tierod_lab.ground.parts import Loads
from tierod_lab.ground.steering.demonstrator import Demonstrator, demonstrator_rack
from tierod_lab.ground.steering.friction import DryFriction

SMOOTH = Demonstrator(rack=replace(demonstrator_rack(), friction=DryFriction(level=0.0)))
IDLE = Loads(0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0), 2000.0, 5.0)
PER_RACK = 1.0 / 146.12
"""Travel of the rack per turn of the column [m/rad]."""


def test_its_modes_are_a_stiff_pair_and_two_slow_ones():
    """Those of eq (3) with the reciprocal ratio; and both motors' lags."""
    point, memory = SMOOTH.stiff(), SMOOTH.remembered()
    matrix = jacobian(lambda motion: SMOOTH.derivative(motion, point, memory, IDLE), point)
    values = np.linalg.eigvals(np.array(matrix, dtype=float))
    stiff = values[np.argmax(values.imag)]
    assert stiff == pytest.approx(-3966.0 + 4187.0j, rel=1e-3)
    slow = np.sort(values[np.abs(values.imag) < 1e-6].real)
    np.testing.assert_allclose(slow, [-1.0 / 3e-3, -1.0 / 3e-3, -22.4, -1.45], rtol=5e-3)


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


def test_shaft_torque_is_less_by_what_speeds_the_motors_up():
    motion = SMOOTH.init()._replace(torque_1=2.0, torque_2=1.0)
    signals = SMOOTH.signals(motion, SMOOTH.remembered(), IDLE)
    acceleration = 3.0 / 0.045
    assert signals.truth_steering_wheel_acceleration == pytest.approx(acceleration)
    assert signals.steering_shaft_torque == pytest.approx(3.0 - 2 * 2.5e-3 * acceleration)
