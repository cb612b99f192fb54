from dataclasses import replace

import numpy as np
import pytest

from monitors.motor_angle.motor_drives import drive, observed
from monitors.motor_angle.steady_motor import TIME, load_torque, steady
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.physics.clarke_park import RotorVector
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters, q_axis_motor, with_load
from tierod_lab.papers.motor_angle.observers import (
    LinearSpeed,
    extended_kalman,
    full_observer,
    luenberger,
    printed_reduced_observer,
    reduced_luenberger,
    reduced_observer,
    speed_per_load,
)

P = load("motor-bench").parameters_for(DqMotorParameters)
MAKERS = [luenberger, reduced_luenberger, extended_kalman]


@pytest.mark.parametrize("make", MAKERS)
def test_with_the_load_as_a_state_speed_and_load_are_right(make):
    found = scan(make(P, TIME, axes="measured"), steady(60.0, 12.0))
    assert found["motor_speed"][-1] == pytest.approx(60.0, rel=0.005)
    assert found["motor_load_torque"][-1] == pytest.approx(load_torque(60.0, 12.0), rel=0.01)


@pytest.mark.parametrize(
    ("make", "per_load"), [(luenberger, -25.73), (reduced_luenberger, -27.78)], ids=["full", "reduced"]
)
def test_without_it_the_speed_is_wrong_in_proportion_to_the_load(make, per_load):
    errors = {}
    for current in (6.0, 12.0):
        found = scan(make(P, TIME, load=False, axes="measured"), steady(60.0, current))
        errors[current] = 60.0 - found["motor_speed"][-1]
    gained = load_torque(60.0, 12.0) - load_torque(60.0, 6.0)
    assert (errors[12.0] - errors[6.0]) / gained == pytest.approx(per_load, rel=0.005)


def test_the_printed_torque_constant_makes_it_wrong_otherwise():
    found = scan(luenberger(P, TIME, load=False, axes="measured", torque_constant="printed"), steady(0.0, 0.6 / 0.051))
    right = scan(luenberger(P, TIME, load=False, axes="measured"), steady(0.0, 0.6 / 0.051))
    assert found["motor_speed"][-1] / right["motor_speed"][-1] == pytest.approx(17.25 / 25.73, rel=0.01)


def test_the_filter_follows_a_drive_and_a_jump_of_the_sensor_enters_measured_axes_only():
    signals = drive(20)
    sensor = signals["sensor"].copy()
    sensor[100_000:] += 0.05
    turning = np.abs(signals["truth_speed"][100_000:]) > 20.0

    def change(axes):
        fault_free, wrong = (observed(extended_kalman(P, TIME, axes=axes), signals, each) for each in (None, sensor))
        return np.sqrt(np.mean((wrong["motor_speed"] - fault_free["motor_speed"])[100_000:][turning] ** 2))

    assert change("own") == 0.0
    assert change("measured") > 0.1


def test_the_swapped_jacobian_still_converges_and_is_worse():
    signals = drive(20)

    def rms(jacobian):
        found = observed(extended_kalman(P, TIME, axes="measured", jacobian=jacobian), signals)
        return np.sqrt(np.mean((found["motor_speed"] - signals["truth_speed"]) ** 2))

    right, printed = rms("corrected"), rms("printed")
    assert right < printed < 3.0 * right


def test_the_angle_begins_at_the_sensor_and_the_residual_is_electrical():
    samples = steady(50.0, 3.0, angle=2.0)
    samples[:30, 4] = np.nan
    samples[3000:, 4] += 0.05
    found = scan(luenberger(P, TIME), samples)
    assert found["motor_angle"][30] == pytest.approx(samples[30, 4])
    assert (found["angle_residual_electrical"][:30] == 0.0).all()
    step = found["angle_residual_electrical"][3000] - found["angle_residual_electrical"][2999]
    assert step == pytest.approx(4.0 * 0.05, abs=1e-3)


def test_missing_voltages_hold_the_speed():
    samples = steady(50.0, 3.0)
    samples[2000:2100, 2] = np.nan
    found = scan(luenberger(P, TIME, axes="measured"), samples)
    assert (found["motor_speed"][2000:2100] == found["motor_speed"][1999]).all()


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="expected own or measured"):
        luenberger(P, TIME, axes="sensor")
    with pytest.raises(ParameterError, match=r"0\.2 at most"):
        extended_kalman(P, 1e-3)
    with pytest.raises(ParameterError, match="expected corrected or printed"):
        extended_kalman(P, TIME, jacobian="swapped")


MOTOR = q_axis_motor(P)
LOADED = with_load(MOTOR, P.motor_inertia)
EMF, TORQUE = 0.034, 0.051


def test_the_reduced_observer_is_eq_32_corrected():
    pole = -300.0
    gain = (pole + P.motor_damping / P.motor_inertia) * P.motor_inductance / EMF
    assert gain == pytest.approx(-0.8725, abs=1e-4)
    found = reduced_observer(MOTOR, (pole,))
    assert found.A[0, 0] == pytest.approx(pole)
    current = pole * gain + TORQUE / P.motor_inertia + gain * P.motor_resistance / P.motor_inductance
    np.testing.assert_allclose(found.B[0], [-gain / P.motor_inductance, current], rtol=1e-12)
    np.testing.assert_allclose(found.D[0], [0.0, gain], rtol=1e-12)


def test_as_printed_the_reduced_observer_diverges_whatever_its_gain():
    for pole in (-100.0, -300.0, -900.0):
        printed = printed_reduced_observer(P, MOTOR, pole)
        assert printed.A[0, 0] == pytest.approx(EMF / P.motor_inductance - P.motor_damping / P.motor_inertia)
        with pytest.raises(ParameterError, match=r"diverges with \+337 1/s"):
            LinearSpeed.of(printed, 1e-4)


@pytest.mark.parametrize("motor", [MOTOR, LOADED], ids=["without load", "with load"])
def test_the_poles_are_where_they_were_wanted(motor):
    poles = (-600.0, -700.0, -300.0)[: len(motor.states)]
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(full_observer(motor, poles).A).real), np.sort(poles))
    fewer = poles[1:]
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(reduced_observer(motor, fewer).A).real), np.sort(fewer))


def test_an_unknown_load_errs_as_the_closed_forms_say():
    poles = (-600.0, -700.0)
    found = full_observer(MOTOR, poles)
    first, second = found.B[:, 1]
    closed = -1.0 / (
        P.motor_damping + EMF * (TORQUE - P.motor_inertia * second) / (P.motor_resistance + P.motor_inductance * first)
    )
    assert speed_per_load(found, MOTOR, P) == pytest.approx(closed, rel=1e-9)
    assert closed == pytest.approx(-25.7, abs=0.05)
    reduced = speed_per_load(reduced_observer(MOTOR, (-300.0,)), MOTOR, P)
    assert reduced == pytest.approx(1.0 / (P.motor_inertia * -300.0), rel=1e-9)


def test_the_load_as_a_state_takes_the_error_away_and_a_wrong_resistance_brings_it_back():
    assert speed_per_load(full_observer(LOADED, (-600.0, -700.0, -300.0)), MOTOR, P) == pytest.approx(0.0, abs=1e-9)
    assert speed_per_load(reduced_observer(LOADED, (-300.0, -200.0)), MOTOR, P) == pytest.approx(0.0, abs=1e-9)
    colder = replace(P, motor_resistance=P.motor_resistance - 0.01)
    wrong = full_observer(with_load(q_axis_motor(colder), P.motor_inertia), (-600.0, -700.0, -300.0))
    assert speed_per_load(wrong, MOTOR, P) == pytest.approx(-0.01 / (EMF * TORQUE), rel=0.02)


def test_sampling_keeps_steady_values():
    observer = full_observer(LOADED, (-600.0, -700.0, -300.0))
    inner = LinearSpeed.of(observer, 1e-4)
    memory = inner.start()
    for _ in range(800):
        memory, estimate = inner.advance(memory, RotorVector(0.0, 2.0), RotorVector(0.0, 12.0))
    expected = -observer.C @ np.linalg.solve(observer.A, observer.B @ [2.0, 12.0])
    np.testing.assert_allclose(estimate, expected, rtol=1e-6)
    assert estimate[0] == pytest.approx((2.0 - 0.05 * 12.0) / EMF)
    assert estimate[1] == pytest.approx(TORQUE * 12.0 - P.motor_damping * estimate[0])
