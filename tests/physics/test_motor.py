"""Motor: Clarke and Park, the machine's equations, the inverter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import motor as pm_motor
from tierod.physics.motor import (
    LONGEST_SIGN,
    PhaseValues,
    RotorVector,
    StatorVector,
    clarke,
    commanded_voltage,
    direction,
    inverse_clarke,
    inverse_park,
    lost_voltage,
    park,
    phase_signs,
)
from tierod_lab.ground import laws

CURRENT = st.floats(-80.0, 80.0)
ANGLE = st.floats(-10.0, 10.0)
SALIENT = {"flux": 0.0083, "inductance_d": 7e-5, "inductance_q": 1.1e-4}


@given(CURRENT, CURRENT, st.floats(-300.0, 300.0), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), ANGLE)
def test_both_forms_of_the_machine_agree(d, q, speed, voltage_alpha, voltage_beta, angle):
    current, voltage = RotorVector(d, q), StatorVector(voltage_alpha, voltage_beta)
    rate = pm_motor.current_rate(
        current, park(voltage, direction(angle)), speed, resistance=0.05, pole_pairs=4, **SALIENT
    )
    flux = RotorVector(SALIENT["flux"] + SALIENT["inductance_d"] * d, SALIENT["inductance_q"] * q)
    linkage = inverse_park(flux, direction(angle))
    flux_rate = pm_motor.stator_flux_rate(voltage, inverse_park(current, direction(angle)), 0.05)

    def after(time):
        moved = StatorVector(*(x + time * slope for x, slope in zip(linkage, flux_rate, strict=True)))
        rotor = direction(angle + 4 * speed * time)
        return np.array(park(laws.current_of_flux(moved, rotor, **SALIENT), rotor))

    small = 1e-7
    np.testing.assert_allclose((after(small) - after(-small)) / (2.0 * small), rate, rtol=1e-4, atol=1.0)


ANY_VALUE = st.floats(-1e3, 1e3)
ANY_ANGLE = st.floats(-1e3, 1e3)


@given(ANY_VALUE, ANY_VALUE)
def test_clarke_inverts(alpha, beta):
    np.testing.assert_allclose(clarke(inverse_clarke(StatorVector(alpha, beta))), (alpha, beta), atol=1e-10)


@given(ANY_VALUE, ANY_VALUE, ANY_ANGLE)
def test_park_inverts_and_keeps_the_length(alpha, beta, angle):
    rotor = direction(angle)
    own = park(StatorVector(alpha, beta), rotor)
    np.testing.assert_allclose(inverse_park(own, rotor), (alpha, beta), atol=1e-9)
    assert math.hypot(*own) == pytest.approx(math.hypot(alpha, beta), abs=1e-9)


@given(st.floats(0.1, 100.0), ANY_ANGLE, st.floats(-3.0, 3.0))
def test_balanced_sines_stand_still_in_the_rotor_and_keep_their_amplitude(amplitude, angle, lead):
    phases = PhaseValues(*(amplitude * math.cos(angle + lead - k * 2.0 * math.pi / 3.0) for k in range(3)))
    own = park(clarke(phases), direction(angle))
    np.testing.assert_allclose(own, (amplitude * math.cos(lead), amplitude * math.sin(lead)), atol=1e-9)


def test_loss_of_small_currents_is_a_resistance():
    current = StatorVector(0.2, -0.1)
    lost = lost_voltage(current, 13.0, 1e-6, 1e-4, 0.7, 1.0)
    np.testing.assert_allclose(lost, np.multiply(current, 13.0 * 0.01 + 0.7), atol=1e-12)


@given(st.floats(-math.pi, math.pi))
def test_the_vector_of_three_signs_points_to_the_middle_of_its_sixth(angle):
    current = StatorVector(50.0 * math.cos(angle), 50.0 * math.sin(angle))
    signs = phase_signs(current, 1e-9)
    if min(abs(value) for value in inverse_clarke(current)) > 1e-6:
        assert math.hypot(*signs) == pytest.approx(LONGEST_SIGN)
        assert np.dot(signs, current) > 0.8 * LONGEST_SIGN * 50.0


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 0.3))
def test_duty_cycles_give_what_they_were_made_for_whatever_all_legs_share(angle, shared):
    wanted = StatorVector(3.0 * math.cos(angle), 3.0 * math.sin(angle))
    duty = PhaseValues(*(0.4 + shared + value / 13.0 for value in inverse_clarke(wanted)))
    np.testing.assert_allclose(commanded_voltage(duty, 13.0), wanted, atol=1e-12)
