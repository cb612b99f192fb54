"""Formulas of the virtual vehicle against published numbers and slow oracles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tierod.physics import friction
from tierod.physics import motor as pm_motor
from tierod.physics import tyre as mf
from tierod.physics.motor import RotorVector, StatorVector, direction, inverse_clarke, inverse_park, park
from tierod.physics.steering import road_wheel_angle
from tierod_lab.ground import laws as control
from tierod_lab.ground import laws as motor
from tierod_lab.ground import laws as steering
from tierod_lab.ground.chassis import laws as chassis
from tierod_lab.ground.control import ActiveReturn
from tierod_lab.ground.motor import Inverter
from tierod_lab.ground.steering import EndStop

FRICTION_ANGLE = math.radians(1.0)


def integrated(normalised, increment, angle, exponent, steps=20_000):
    """A slow oracle: Dahl's equation, 1976, by many small midpoint steps, (n,) at once."""
    direction, part = np.copysign(1.0, increment), increment / steps

    def slope(level):
        gap = 1.0 - level * direction
        return np.abs(gap) ** exponent * np.sign(gap) / angle

    for _ in range(steps):
        normalised = normalised + part * slope(normalised + 0.5 * part * slope(normalised))
    return normalised


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 3.0])
def test_closed_form_is_the_integral_of_dahls_equation(exponent):
    starts, turns = np.meshgrid([-1.0, -0.4, 0.0, 0.7], [-2.0, -0.1, 0.3, 1.7])
    found = integrated(starts.ravel(), turns.ravel() * FRICTION_ANGLE, FRICTION_ANGLE, exponent)
    for start, turned, each in zip(starts.ravel(), turns.ravel(), found, strict=True):
        exact = steering.dahl_power_update(start, turned * FRICTION_ANGLE, FRICTION_ANGLE, exponent)
        assert exact == pytest.approx(each, abs=2e-4), (start, turned)


def test_exponent_below_one_reaches_the_level_after_a_finite_travel():
    assert steering.dahl_power_update(-1.0, 2.0 * math.sqrt(2.0) * FRICTION_ANGLE * 1.001, FRICTION_ANGLE, 0.5) == 1.0
    assert steering.dahl_power_update(-1.0, 2.0 * math.sqrt(2.0) * FRICTION_ANGLE * 0.9, FRICTION_ANGLE, 0.5) < 1.0


def test_stribeck_falls_from_static_to_sliding():
    assert steering.stribeck_level(0.0, 6.0, 4.0, 0.1) == pytest.approx(6.0)
    assert steering.stribeck_level(-0.1, 6.0, 4.0, 0.1) == pytest.approx(4.0 + 2.0 / math.e)
    assert steering.stribeck_level(5.0, 6.0, 4.0, 0.1) == pytest.approx(4.0)


def test_lugre_settles_at_the_steady_curve_and_equals_dahl_without_damping():
    stiffness, level, rate, deflection, step = 400.0, 4.0, 0.3, 0.0, 1e-5
    for _ in range(20_000):
        deflection += step * steering.lugre_bristle_rate(deflection, rate, stiffness, level)
    torque = steering.lugre_torque(deflection, 0.0, rate, stiffness, 0.0, 0.0)
    dahl = level * friction.dahl_update(0.0, 20_000 * step * rate, level / stiffness)
    assert torque == pytest.approx(dahl, rel=1e-3)
    settled = steering.lugre_torque(level / stiffness, 0.0, rate, stiffness, 1.0, 0.8)
    assert settled == pytest.approx(level + 0.8 * rate)


RETURN = ActiveReturn(rate_gain=1.5, maximum_rate=3.0, gain=2.0, best_speed=6.0, fade_torque=1.0)


def test_active_return_pulls_to_the_middle_at_a_wanted_rate_when_rolling_and_released():
    assert RETURN.torque(1.0, 0.0, 6.0, 0.0) == pytest.approx(-3.0)
    assert RETURN.torque(1.0, -1.5, 6.0, 0.0) == pytest.approx(0.0)
    assert RETURN.torque(-8.0, 0.0, 6.0, 0.0) == pytest.approx(6.0)
    speeds = np.linspace(0.0, 40.0, 401)
    torques = RETURN.torque(-8.0, 0.0, speeds, 0.0)
    assert torques[0] == 0.0
    assert speeds[np.argmax(torques)] == pytest.approx(6.0)
    assert RETURN.torque(-8.0, 0.0, 6.0, -1.0) == pytest.approx(3.0)


TOOTH_STIFFNESS, DAMPING, PLAY = 2000.0, 0.5, 0.01


def test_dead_zone_is_as_wide_as_the_play():
    twist = np.linspace(-0.02, 0.02, 4001)
    torque = steering.lash_torque(twist, 0.0 * twist, TOOTH_STIFFNESS, DAMPING, PLAY)
    free = twist[torque == 0.0]
    assert free[-1] - free[0] == pytest.approx(PLAY, abs=2.1e-5)
    assert steering.lash_torque(0.5 * PLAY + 1e-3, 0.0, TOOTH_STIFFNESS, DAMPING, PLAY) == pytest.approx(2.0)
    assert steering.lash_torque(-0.5 * PLAY - 1e-3, 0.0, TOOTH_STIFFNESS, DAMPING, PLAY) == pytest.approx(-2.0)


@given(st.floats(-0.05, 0.05), st.floats(-10, 10), st.floats(1e-5, 0.02))
def test_flanks_push_and_never_pull(twist, rate, play):
    torque = steering.lash_torque(twist, rate, TOOTH_STIFFNESS, DAMPING, play)
    assert torque * twist >= 0.0
    assert steering.lash_torque(-twist, -rate, TOOTH_STIFFNESS, DAMPING, play) == -torque


STOP = EndStop(8.5, 400.0, 5.0)


def test_both_sides_push_back_beyond_the_lock_only():
    assert STOP.torque(8.6, 0.0) == pytest.approx(40.0)
    assert STOP.torque(-8.6, 0.0) == pytest.approx(-40.0)
    assert STOP.torque(8.6, 1.0) == pytest.approx(45.0)
    assert STOP.torque(8.5, 3.0) == 0.0
    assert STOP.torque(-8.4, -3.0) == 0.0


@given(st.floats(-10, 10), st.floats(0, 0.01))
def test_ratio_is_the_slope_of_the_angle(angle, growth):
    step = 1e-4
    rise = road_wheel_angle(angle + step, 0.065, growth) - road_wheel_angle(angle - step, 0.065, growth)
    assert rise / (2.0 * step) == pytest.approx(steering.variable_ratio(angle, 0.065, growth), rel=1e-6)


TRACK, WHEELBASE = 1.55, 2.83


@pytest.mark.parametrize(("steer", "error"), [(0.1, 0.005), (-0.2, 0.02), (0.35, 0.055), (-0.5, 0.12)])
def test_full_gain_lets_both_wheels_roll_about_one_centre(steer, error):
    radius = WHEELBASE / math.tan(steer)
    left = math.atan(WHEELBASE / (radius - 0.5 * TRACK))
    right = math.atan(WHEELBASE / (radius + 0.5 * TRACK))
    mean, gain = 0.5 * (left + right), 0.5 * TRACK / WHEELBASE
    difference = steering.ackermann_angle(mean, gain) - steering.ackermann_angle(mean, -gain)
    assert difference == pytest.approx(left - right, rel=error)
    assert 0.5 * (steering.ackermann_angle(mean, gain) + steering.ackermann_angle(mean, -gain)) == pytest.approx(mean)


@given(st.floats(-0.7, 0.7), st.floats(-0.3, 0.3))
def test_slope_is_the_derivative(steer, gain):
    rise = steering.ackermann_angle(steer + 1e-5, gain) - steering.ackermann_angle(steer - 1e-5, gain)
    assert steering.ackermann_slope(steer, gain) == pytest.approx(rise / 2e-5, rel=1e-6)


STIFFNESS, ADHESION, TYRE_LOAD, HALF_LENGTH = 110e3, 0.9, 9000.0, 0.075
LIMIT = ADHESION * TYRE_LOAD
BRUSH = (STIFFNESS, ADHESION, TYRE_LOAD)


def test_brush_is_fialas_polynomial():
    slip = np.linspace(0.0, 0.9, 7) * 3.0 * LIMIT / STIFFNESS
    fiala = STIFFNESS * slip - STIFFNESS**2 * slip**2 / (3.0 * LIMIT) + STIFFNESS**3 * slip**3 / (27.0 * LIMIT**2)
    np.testing.assert_allclose(chassis.brush_lateral_force(slip, *BRUSH), fiala, rtol=1e-12, atol=1e-9)


def test_aligning_torque_peaks_at_a_quarter_of_the_sliding_slip():
    slip = np.linspace(0.0, 1.0, 4001) * 3.0 * LIMIT / STIFFNESS
    torque = chassis.brush_aligning_torque(slip, *BRUSH, HALF_LENGTH)
    assert slip[np.argmax(torque)] / slip[-1] == pytest.approx(0.25, abs=1e-3)
    assert torque.max() == pytest.approx(LIMIT * HALF_LENGTH * 27.0 / 256.0)


def test_relaxation_settles_at_the_slip_and_holds_when_standing():
    deflection, speed, length = 0.0, 10.0, 0.3
    for _ in range(10_000):
        deflection += 1e-4 * chassis.bounded_relaxation_rate(deflection, speed * 0.02, speed, length, 0.0)
    assert deflection / length == pytest.approx(0.02, rel=1e-6)
    assert chassis.bounded_relaxation_rate(0.01, 0.0, 0.0, length, 0.0) == 0.0


def test_parking_torque_of_a_mid_size_car():
    wheel = chassis.parking_torque(4700.0, 0.9, 2.2e5)
    assert wheel == pytest.approx(0.9 * 4700.0 / 3.0 * math.sqrt(4700.0 / 2.2e5))
    assert 15.0 < 2.0 * wheel / 15.5 < 35.0


def test_the_deflection_of_a_dragged_tyre_is_bounded_and_that_of_a_rolling_one_is_not_touched():
    deflection, length = 0.0, 0.4
    for _ in range(10_000):
        speed = chassis.relaxation_speed(0.0, 1.0, 0.3)
        deflection += 1e-3 * chassis.bounded_relaxation_rate(deflection, 1.0, speed, length, 0.0)
    assert deflection == pytest.approx(0.3 * length)
    assert chassis.relaxation_speed(100.0, (0.06 * 10.0) ** 2, 0.3) == pytest.approx(10.0, rel=4.1e-4)
    assert chassis.relaxation_speed(0.0, 0.0, 0.3) == 0.0


SHAPE, CURVATURE = 1.38, -0.3
KX, KY, MUX, MUY, TYRE_LOAD = 25.0, 18.0, 1.1, 1.0, 4200.0


@pytest.mark.parametrize("load", [0.0, 1000.0, 4500.0, 9000.0, 14000.0])
def test_stiffness_by_load_is_the_sine_of_the_books(load):
    ours = load * chassis.stiffness_per_load(load, 4500.0, 22.0, 2.0)
    assert ours == pytest.approx(22.0 * 4500.0 * math.sin(2.0 * math.atan(load / 9000.0)))


def forces(along, across):
    return chassis.combined_forces((along, across), (KX, KY), (MUX, MUY), TYRE_LOAD, SHAPE, CURVATURE)


@pytest.mark.parametrize("slip", [1e-3, 0.03, 0.1, 0.5])
def test_one_slip_alone_gives_the_pure_curve(slip):
    lateral = forces(0.0, slip)
    assert lateral.longitudinal == 0.0
    factor = KY / (SHAPE * MUY)
    assert lateral.lateral == pytest.approx(mf.magic_formula(slip, factor, SHAPE, MUY * TYRE_LOAD, CURVATURE), rel=1e-6)
    factor = KX / (SHAPE * MUX)
    pure = mf.magic_formula(slip, factor, SHAPE, MUX * TYRE_LOAD, CURVATURE)
    assert forces(slip, 0.0).longitudinal == pytest.approx(pure, rel=1e-6)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_forces_stay_within_the_ellipse_and_along_their_slips(along, across):
    found = forces(along, across)
    share = math.hypot(found.longitudinal / (MUX * TYRE_LOAD), found.lateral / (MUY * TYRE_LOAD))
    assert share <= 1.0 + 1e-9
    assert found.longitudinal * along >= 0.0
    assert found.lateral * across >= 0.0


CURRENT = st.floats(-80.0, 80.0)
MOTOR_ANGLE = st.floats(-10.0, 10.0)
SALIENT = {"flux": 0.0083, "inductance_d": 7e-5, "inductance_q": 1.1e-4}


@given(CURRENT, CURRENT, MOTOR_ANGLE)
def test_flux_and_current_go_with_each_other(d, q, angle):
    rotor = direction(angle)
    flux, inductance_d, inductance_q = SALIENT.values()
    linkage = inverse_park(RotorVector(flux + inductance_d * d, inductance_q * q), rotor)
    current = motor.current_of_flux(linkage, rotor, **SALIENT)
    np.testing.assert_allclose(park(current, rotor), (d, q), atol=1e-9)
    torque = pm_motor.electromagnetic_torque(RotorVector(d, q), 4, **SALIENT)
    assert motor.torque_of_flux(linkage, current, 4) == pytest.approx(torque, abs=1e-9)


VALUE = st.floats(-100.0, 100.0)


@given(st.floats(-math.pi, math.pi))
def test_the_longest_vector_can_be_made_in_every_direction_and_just_so(angle):
    length = Inverter(supply_voltage=13.0, modulation=1.0).longest_voltage
    phases = inverse_clarke(StatorVector(length * math.cos(angle), length * math.sin(angle)))
    assert max(phases) - min(phases) <= 13.0 * (1.0 + 1e-12)


@given(VALUE, VALUE)
def test_limit_keeps_the_direction_and_short_vectors(d, q):
    wanted = RotorVector(d, q)
    made = motor.limited_voltage(wanted, 7.5)
    assert isinstance(made, RotorVector)
    assert math.hypot(*made) <= 7.5 * (1.0 + 1e-12)
    assert made.d * q == pytest.approx(made.q * d, abs=1e-9)
    if math.hypot(d, q) < 7.5:
        np.testing.assert_allclose(made, wanted, rtol=1e-12)


@pytest.mark.parametrize("offset", [-0.5, 0.2])
def test_the_arc_meets_the_path_at_the_reach(offset):
    curvature = control.pursuit_curvature(offset, 20.0)
    assert offset + (1.0 - math.cos(20.0 * curvature)) / curvature == pytest.approx(0.0, abs=1e-3)
