"""The balance of the voltage over a motor computed in closed form: a rotor at changing speed, currents of its own."""

from __future__ import annotations

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding
from tierod.monitors.motor_angle.balance import AS_RECORDED, READINGS, VoltageBalance

RESISTANCE, INDUCTANCE, FLUX, PAIRS, STEP = 0.05, 1e-4, 0.0085, 4.0, 1e-4
TIME = np.arange(20_000) * STEP
ANGLE = 3.0 * np.sin(7.0 * TIME) + 10.0 * TIME
CURRENT = (10.0 * np.cos(11.0 * TIME) + 4j * np.sin(5.0 * TIME)) * np.exp(1j * PAIRS * ANGLE)


def voltage(current=CURRENT, signs=0.0, loss=0.0):
    """Means over the samples that end, from the integral of the equation."""
    linkage = INDUCTANCE * current + FLUX * np.exp(1j * PAIRS * ANGLE)
    mean = np.diff(linkage) / STEP + RESISTANCE * 0.5 * (current[1:] + current[:-1])
    return np.concatenate([[0.0], mean + loss * 0.5 * (signs[1:] + signs[:-1]) if loss else mean])


def balanced(current, voltage, angle=ANGLE, signs=None, pieces=1):
    found = VoltageBalance(PAIRS, STEP)
    signs = np.zeros(len(current)) if signs is None else signs
    for part in np.array_split(np.arange(len(current)), pieces):
        found.add(current[part], voltage[part], angle[part], signs[part])
    return found


def test_it_finds_the_motor_whatever_the_pieces():
    for pieces in (1, 7):
        found = balanced(CURRENT, voltage(), pieces=pieces).best()
        assert found.reading == AS_RECORDED
        assert (found.resistance, found.inductance, found.flux) == pytest.approx((RESISTANCE, INDUCTANCE, FLUX))
        assert found.flux_direction == pytest.approx(0.0, abs=1e-9)
        assert found.unexplained < 1e-6
        assert found.windows == 399


@pytest.mark.parametrize("reading", READINGS)
def test_it_finds_how_a_recording_must_be_read(reading):
    recorded = CURRENT * np.exp(-1j * reading.shifted)
    # A mirrored current is read by its conjugate: turned on after it was mirrored, so back before.
    recorded = np.conj(recorded) if reading.mirrored else recorded
    found = balanced(recorded, voltage(), -ANGLE if reading.backwards else ANGLE).best()
    assert found.reading == reading
    assert found.resistance == pytest.approx(RESISTANCE)


@pytest.mark.parametrize("factor", [-1.0, 2.0])
def test_a_target_that_is_wrong_is_named_where_the_sensor_is_confirmed(factor):
    target = FAULT_FREE().samples[:, COLUMN["target_motor_angle_mechanical"]]
    found = finding(changed(target_motor_angle_mechanical=factor * target))
    assert "target_motor_angle_mechanical" in found.cause
    assert "confirm the sensor" in found.cause
