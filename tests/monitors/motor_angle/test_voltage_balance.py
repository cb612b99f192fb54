"""The balance of the voltage over a motor computed in closed form: a rotor at changing speed, currents of its own."""

from __future__ import annotations

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding

RESISTANCE, INDUCTANCE, FLUX, PAIRS, STEP = 0.05, 1e-4, 0.0085, 4.0, 1e-4
TIME = np.arange(20_000) * STEP
ANGLE = 3.0 * np.sin(7.0 * TIME) + 10.0 * TIME
CURRENT = (10.0 * np.cos(11.0 * TIME) + 4j * np.sin(5.0 * TIME)) * np.exp(1j * PAIRS * ANGLE)


def voltage(current=CURRENT, signs=0.0, loss=0.0):
    """Means over the samples that end, from the integral of the equation."""
    linkage = INDUCTANCE * current + FLUX * np.exp(1j * PAIRS * ANGLE)
    mean = np.diff(linkage) / STEP + RESISTANCE * 0.5 * (current[1:] + current[:-1])
    return np.concatenate([[0.0], mean + loss * 0.5 * (signs[1:] + signs[:-1]) if loss else mean])


@pytest.mark.parametrize("factor", [-1.0, 2.0])
def test_a_target_that_is_wrong_is_named_where_the_sensor_is_confirmed(factor):
    target = FAULT_FREE().samples[:, COLUMN["target_motor_angle_mechanical"]]
    found = finding(changed(target_motor_angle_mechanical=factor * target))
    assert "target_motor_angle_mechanical" in found.cause
    assert "confirm the sensor" in found.cause
