"""Signals that no motor brings, named by the finding over a recording."""

import numpy as np
import pytest

from exact_vehicle import diagnose
from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, recording
from tierod.core.findings import Status
from tierod.physics.clarke_park import StatorVector, inverse_clarke


def finding(samples):
    return diagnose(recording(samples), "motor-bench", "motor-angle").findings[0]


def column(name):
    return FAULT_FREE().samples[:, COLUMN[name]]


@pytest.mark.parametrize(
    ("signal", "share", "cause"),
    [
        ("motor_current_alpha", 0.5, "its measurement is saturated"),
        ("motor_current_beta", 0.3, "its measurement is saturated"),
        ("motor_voltage_beta", 0.4, "its measurement is saturated"),
    ],
)
def test_a_saturated_signal_is_named(signal, share, cause):
    values = column(signal)
    most = share * np.abs(values).max()
    found = finding(changed(**{signal: np.clip(values, -most, most)}))
    assert found.status is Status.FAULT
    assert cause in found.cause
    assert ("current" if "current" in signal else "voltage") in found.cause
    assert "widen the range" in found.action


@pytest.mark.parametrize(
    ("gain", "offset"), [(1.0, 5.0), (0.5, 0.0)], ids=["offset of a phase", "a phase of half its gain"]
)
def test_phase_currents_that_do_not_sum_to_zero_are_named(gain, offset):
    """What is recorded of the phases goes into the axes that the observer is given."""
    a, b, c = inverse_clarke(StatorVector(column("motor_current_alpha"), column("motor_current_beta")))
    b = gain * b + offset
    alpha, beta = (2.0 * a - b - c) / 3.0, (b - c) / 3.0**0.5
    phases = {"motor_current_a": a, "motor_current_b": b, "motor_current_c": c}
    found = finding(changed(**phases, motor_current_alpha=alpha, motor_current_beta=beta))
    assert found.status is Status.FAULT
    assert found.cause == "the phase currents do not add up to zero"


@pytest.mark.parametrize("signal", ["motor_current_alpha", "motor_current_beta", "motor_voltage_alpha"])
def test_a_gain_that_grows_does_not_accuse_the_angle_sensor_alone(signal):
    values = column(signal)
    growth = np.clip(np.linspace(-0.5, 1.0, len(values)), 0.0, 1.0)
    found = finding(changed(**{signal: values * (1.0 + growth)}))
    assert found.status in (Status.FAULT, Status.SUSPECT)
    assert "currents and voltages" in found.cause
    assert "contradict the model of the motor" in found.cause or "either may be wrong" in found.cause
