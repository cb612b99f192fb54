import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import pm_motor
from tierod.physics.clarke_park import RotorVector, StatorVector, direction, inverse_park, park

CURRENT = st.floats(-80.0, 80.0)
ANGLE = st.floats(-10.0, 10.0)
SALIENT = {"flux": 0.0083, "inductance_d": 7e-5, "inductance_q": 1.1e-4}


def test_torque_constant_is_three_halves_of_the_voltage_constant():
    assert pm_motor.back_emf_constant(4, 0.0085) == pytest.approx(0.034)
    assert pm_motor.torque_constant(4, 0.0085) == pytest.approx(0.051)


@given(CURRENT, CURRENT, ANGLE)
def test_flux_and_current_go_with_each_other(d, q, angle):
    rotor = direction(angle)
    linkage = inverse_park(pm_motor.flux_linkage(RotorVector(d, q), **SALIENT), rotor)
    current = pm_motor.current_of_flux(linkage, rotor, **SALIENT)
    np.testing.assert_allclose(park(current, rotor), (d, q), atol=1e-9)
    torque = pm_motor.electromagnetic_torque(RotorVector(d, q), 4, **SALIENT)
    assert pm_motor.torque_of_flux(linkage, current, 4) == pytest.approx(torque, abs=1e-9)


@given(CURRENT, CURRENT, st.floats(-300.0, 300.0), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), ANGLE)
def test_both_forms_of_the_machine_agree(d, q, speed, voltage_alpha, voltage_beta, angle):
    current, voltage = RotorVector(d, q), StatorVector(voltage_alpha, voltage_beta)
    rate = pm_motor.current_rate(
        current, park(voltage, direction(angle)), speed, resistance=0.05, pole_pairs=4, **SALIENT
    )
    linkage = inverse_park(pm_motor.flux_linkage(current, **SALIENT), direction(angle))
    flux_rate = pm_motor.stator_flux_rate(voltage, inverse_park(current, direction(angle)), 0.05)

    def after(time):
        moved = StatorVector(*(x + time * slope for x, slope in zip(linkage, flux_rate, strict=True)))
        rotor = direction(angle + 4 * speed * time)
        return np.array(park(pm_motor.current_of_flux(moved, rotor, **SALIENT), rotor))

    small = 1e-7
    np.testing.assert_allclose((after(small) - after(-small)) / (2.0 * small), rate, rtol=1e-4, atol=1.0)


@given(CURRENT, CURRENT, st.floats(-300.0, 300.0), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), ANGLE)
def test_the_current_in_the_stators_axes_goes_as_its_flux_does(d, q, speed, alpha, beta, angle):
    rotor, voltage = direction(angle), StatorVector(alpha, beta)
    current = inverse_park(RotorVector(d, q), rotor)
    rate = pm_motor.salient_stator_current_rate(
        current, voltage, rotor, speed, resistance=0.05, pole_pairs=4, **SALIENT
    )
    linkage = inverse_park(pm_motor.flux_linkage(RotorVector(d, q), **SALIENT), rotor)
    flux_rate = pm_motor.stator_flux_rate(voltage, current, 0.05)

    def after(time):
        moved = StatorVector(*(x + time * slope for x, slope in zip(linkage, flux_rate, strict=True)))
        return np.array(pm_motor.current_of_flux(moved, direction(angle + 4 * speed * time), **SALIENT))

    small = 1e-7
    np.testing.assert_allclose((after(small) - after(-small)) / (2.0 * small), rate, rtol=1e-4, atol=1.0)
    plain = {"resistance": 0.05, "flux": 0.0083, "pole_pairs": 4}
    round_ = pm_motor.salient_stator_current_rate(
        current, voltage, rotor, speed, inductance_d=1e-4, inductance_q=1e-4, **plain
    )
    np.testing.assert_allclose(
        round_, pm_motor.stator_current_rate(current, voltage, rotor, speed, inductance=1e-4, **plain), atol=1e-3
    )


def test_power_is_heat_and_work_in_the_steady_state():
    current, speed = RotorVector(0.0, 20.0), 50.0
    voltage = RotorVector(-4 * speed * 1e-4 * 20.0, 0.05 * 20.0 + 4 * speed * 0.0085)
    np.testing.assert_allclose(
        pm_motor.current_rate(
            current,
            voltage,
            speed,
            resistance=0.05,
            inductance_d=1e-4,
            inductance_q=1e-4,
            flux=0.0085,
            pole_pairs=4,
        ),
        (0.0, 0.0),
        atol=1e-9,
    )
    work = speed * pm_motor.electromagnetic_torque(current, 4, 0.0085, 1e-4, 1e-4)
    power = pm_motor.electric_power(StatorVector(*voltage), StatorVector(*current))
    assert power == pytest.approx(work + pm_motor.copper_loss(StatorVector(*current), 0.05))


def test_rotor_acceleration_is_the_balance_of_torques():
    assert pm_motor.rotor_acceleration(0.5, 0.2, 100.0, 1e-4, 1e-3) == pytest.approx(2000.0)


@given(ANGLE)
def test_slots_pull_six_times_per_electrical_turn(angle):
    assert pm_motor.cogging_torque(direction(angle), 0.01) == pytest.approx(0.01 * math.sin(6.0 * angle), abs=1e-12)


def test_temperature_raises_resistance_and_weakens_magnets():
    assert pm_motor.resistance_at(393.15, 0.05) == pytest.approx(0.05 * (235.0 + 120.0) / 255.0)
    assert pm_motor.resistance_at(293.15, 0.05) == 0.05
    assert pm_motor.flux_at(393.15, 1.0) == pytest.approx(0.89)
