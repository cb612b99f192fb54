"""Currents asked of a salient motor: torque as wanted, with the least current, within the voltage."""

import numpy as np
import pytest

from tierod.physics.clarke_park import RotorVector
from tierod.physics.pm_motor import electromagnetic_torque
from tierod_lab.ground.motor.control import SetPoints

RATIOS = (1.0, 1.5, 3.0)
LIMIT = 60.0


def points(ratio):
    return SetPoints(1e-4 * ratio**-0.8, 1e-4 * ratio**0.2, 0.0085, LIMIT)


def torque(current, ratio):
    own = points(ratio)
    return electromagnetic_torque(current, 4.0, own.flux, own.inductance_d, own.inductance_q)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("wanted", [-40.0, -5.0, 0.0, 20.0, 40.0])
def test_slow_it_makes_the_torque_with_the_least_current(ratio, wanted):
    found = points(ratio).of(wanted, 10.0, 7.0)
    assert torque(found, ratio) == pytest.approx(1.5 * 4.0 * 0.0085 * wanted, rel=0.01, abs=1e-9)
    along = np.linspace(-50.0, 20.0, 2001)
    apart = points(ratio).inductance_q - points(ratio).inductance_d
    across = 0.0085 * wanted / (0.0085 - apart * along)
    assert np.hypot(*found) <= np.hypot(along, across).min() * 1.01 + 1e-9


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("speed", [-1000.0, 800.0, 1000.0])
def test_fast_it_keeps_within_the_voltage_and_the_current(ratio, speed):
    own = points(ratio)
    for wanted in np.linspace(-60.0, 60.0, 25):
        found = own.of(wanted, speed, 7.0)
        linkage = np.hypot(own.flux + own.inductance_d * found.d, own.inductance_q * found.q)
        assert abs(speed) * linkage <= 7.0 * 1.001
        assert np.hypot(*found) <= LIMIT * 1.001


def test_without_saliency_and_slow_there_is_none_along_the_flux():
    assert points(1.0).of(30.0, 100.0, 7.0) == pytest.approx(RotorVector(0.0, 30.0))
