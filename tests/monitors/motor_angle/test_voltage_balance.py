"""The balance of the voltage over a motor computed in closed form: a rotor at changing speed, currents of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding
from tierod.monitors.motor_angle.balance import AS_RECORDED, FITS, READINGS, InducedVoltage, VoltageBalance
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.bench import RATE

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


@pytest.mark.parametrize("ratio", [0.6, 1.7])
@pytest.mark.parametrize("zero", [0.0, 1.1])
def test_a_known_saliency_is_taken_beside_the_flux_wherever_the_sensor_s_zero_lies(ratio, zero):
    """The linkage of a salient motor from its definition: L_d and L_q on the rotor's own axes."""
    rotor = np.exp(1j * PAIRS * ANGLE)
    own = CURRENT * np.conj(rotor)
    linkage = INDUCTANCE * (own.real + 1j * ratio * own.imag) * rotor + FLUX * rotor
    made = np.diff(linkage) / STEP + RESISTANCE * 0.5 * (CURRENT[1:] + CURRENT[:-1])
    collected = VoltageBalance(PAIRS, STEP, (1.0 - ratio) / (1.0 + ratio))
    collected.add(CURRENT, np.concatenate([[0.0], made]), ANGLE - zero / PAIRS, np.zeros(len(CURRENT)))
    found = collected.over(AS_RECORDED)
    assert found.inductance == pytest.approx(0.5 * (1.0 + ratio) * INDUCTANCE, rel=0.03)
    assert found.flux_direction == pytest.approx(zero, abs=0.03)
    assert found.resistance == pytest.approx(RESISTANCE, rel=0.03)


def test_angles_that_come_seldom_and_gaps_change_nothing():
    angle, current = ANGLE.copy(), CURRENT.copy()
    angle[np.arange(len(angle)) % 10 != 0] = np.nan
    current[5000:5100] = np.nan
    found = balanced(current, voltage(), angle, pieces=3).best()
    assert found.resistance == pytest.approx(RESISTANCE)
    assert 390 <= found.windows < 399


def test_what_an_inverter_takes_is_a_column_of_its_own():
    signs = np.sign(CURRENT.real) + 0j
    found = balanced(CURRENT, voltage(signs=signs, loss=0.5), signs=signs).best()
    assert found.resistance == pytest.approx(RESISTANCE)
    assert balanced(CURRENT, voltage(signs=signs, loss=0.5)).best().unexplained > 0.02


@pytest.mark.parametrize("reading", READINGS)
def test_the_signs_are_read_as_the_currents_are(reading):
    signs = np.sign(CURRENT.real) + 1j * np.sign(CURRENT.imag)
    recorded = [each * np.exp(-1j * reading.shifted) for each in (CURRENT, signs)]
    recorded = [np.conj(each) if reading.mirrored else each for each in recorded]
    balance = balanced(recorded[0], voltage(signs=signs, loss=0.5), -ANGLE if reading.backwards else ANGLE, recorded[1])
    found = balance.over(reading)
    assert found.unexplained < 1e-6
    assert found.resistance == pytest.approx(RESISTANCE)


def test_a_motor_that_stands_without_current_shows_nothing():
    nothing = np.zeros(2000)
    assert balanced(nothing + 0j, nothing, nothing).best() is None


def test_long_recordings_are_put_together(monkeypatch):
    whole = balanced(CURRENT, voltage())
    monkeypatch.setattr("tierod.monitors.motor_angle.balance.PART", 7)
    monkeypatch.setattr("tierod.monitors.motor_angle.balance.MOST_PARTS", 20)
    merged = balanced(CURRENT, voltage(), pieces=9)
    assert merged.best().resistance == pytest.approx(whole.best().resistance)
    assert merged.best().windows == whole.best().windows
    first, second = merged.halves(AS_RECORDED)
    assert first.windows + second.windows == merged.best().windows
    assert min(first.windows, second.windows) > 0.3 * merged.best().windows


MOTOR = load("motor-bench")


def share(samples, pieces=1):
    induced = InducedVoltage(MOTOR["motor_resistance"], MOTOR["motor_inductance"], MOTOR["motor_flux"], 1.0 / RATE)
    for piece in np.array_split(samples, pieces):
        current = piece[:, COLUMN["motor_current_alpha"]] + 1j * piece[:, COLUMN["motor_current_beta"]]
        voltage = piece[:, COLUMN["motor_voltage_alpha"]] + 1j * piece[:, COLUMN["motor_voltage_beta"]]
        induced.add(current, voltage)
    return induced.share()


def test_those_of_one_motor_fit_however_they_are_cut():
    assert share(FAULT_FREE().samples) < 0.5 * FITS
    assert share(FAULT_FREE().samples, 37) == pytest.approx(share(FAULT_FREE().samples), rel=1e-9)


@pytest.mark.parametrize("name", ["motor_current_alpha", "motor_voltage_beta"])
@pytest.mark.parametrize("factor", [-1.0, 0.5, 2.0])
def test_one_that_is_wrong_does_not(name, factor):
    assert share(changed(**{name: factor * FAULT_FREE().samples[:, COLUMN[name]]})) > 2.0 * FITS


def test_a_motor_that_stands_still_says_nothing():
    assert math.isnan(share(FAULT_FREE().samples[:100]))


@pytest.mark.parametrize("factor", [-1.0, 2.0])
def test_a_target_that_is_wrong_is_named_where_the_sensor_is_confirmed(factor):
    target = FAULT_FREE().samples[:, COLUMN["target_motor_angle_mechanical"]]
    found = finding(changed(target_motor_angle_mechanical=factor * target))
    assert "target_motor_angle_mechanical" in found.cause
    assert "confirm the sensor" in found.cause
