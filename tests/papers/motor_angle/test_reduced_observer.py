"""Design of the linear observers against the paper's closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.physics.clarke_park import RotorVector
from tierod.vehicles import load
from tierod_lab.papers.motor_angle.dq_motor import DqMotorParameters, q_axis_motor, with_load
from tierod_lab.papers.motor_angle.luenberger import (
    LinearSpeed,
    full_observer,
    printed_reduced_observer,
    reduced_observer,
    speed_per_load,
)

P = load("motor-bench").parameters_for(DqMotorParameters)
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
    """Constant voltage and current: the sampled observer settles where the continuous one does."""
    observer = full_observer(LOADED, (-600.0, -700.0, -300.0))
    inner = LinearSpeed.of(observer, 1e-4)
    memory = inner.start()
    for _ in range(800):
        memory, estimate = inner.advance(memory, RotorVector(0.0, 2.0), RotorVector(0.0, 12.0))
    expected = -observer.C @ np.linalg.solve(observer.A, observer.B @ [2.0, 12.0])
    np.testing.assert_allclose(estimate, expected, rtol=1e-6)
    assert estimate[0] == pytest.approx((2.0 - 0.05 * 12.0) / EMF)
    assert estimate[1] == pytest.approx(TORQUE * 12.0 - P.motor_damping * estimate[0])
