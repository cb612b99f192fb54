"""Signals that no motor brings: by the checks of the block, and as the finding over a recording names them."""

import numpy as np
import pytest

from monitors.motor_angle.monitored import COLUMN, FAULT_FREE, changed, finding
from tierod.core.findings import Status
from tierod.core.graph import scan
from tierod.monitors.motor_angle.comparison import ElectricalAlarms, ElectricalChecks
from tierod.monitors.motor_angle.observer import MotorAngleSample

TIME = np.arange(6000) / 1e4
ANGLE = 40.0 * TIME
FAULT = slice(4000, 6000)


def fault_free():
    random = np.random.default_rng(1)
    noise = lambda: 0.1 * random.normal(size=len(TIME))  # noqa: E731
    electrical = 4.0 * ANGLE
    phases = [10.0 * np.cos(electrical - shift) + noise() for shift in (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0)]
    values = dict.fromkeys(MotorAngleSample._fields, np.full(len(TIME), np.nan))
    values |= dict(zip(("motor_current_a", "motor_current_b", "motor_current_c"), phases, strict=True))
    values |= {
        "motor_angle_mechanical": ANGLE % (2.0 * np.pi),
        "motor_current_alpha": phases[0],
        "motor_voltage_beta": 3.0 * np.sin(electrical) + 0.01 * noise(),
        "resolver_sine": 2.0 * np.sin(electrical),
        "resolver_cosine": 2.0 * np.cos(electrical),
        "supply_voltage": 13.0 + noise(),
    }
    return {name: np.array(value) for name, value in values.items()}


def failing(values):
    found = scan(ElectricalChecks(4.0), np.column_stack([values[name] for name in MotorAngleSample._fields]))
    flags = {name: found[f"alarms.{name}"] for name in ElectricalAlarms._fields}
    return {name: int(np.argmax(flag)) for name, flag in flags.items() if flag.any()}


CASES = {
    "supply_low": ("supply_voltage", lambda x: x - 6.0),
    "angle_timeout": ("motor_angle_mechanical", lambda x: x * np.nan),
    "angle_gradient": ("motor_angle_mechanical", lambda x: x + 1.0),
    "resolver_amplitude": ("resolver_sine", lambda x: 0.6 * x),
    "resolver_mismatch": ("motor_angle_mechanical", lambda x: x + 0.03),
    "current_sum": ("motor_current_b", lambda x: x + 4.0),
    "current_saturated": ("motor_current_alpha", lambda x: np.clip(x, -7.0, 7.0)),
    "voltage_saturated": ("motor_voltage_beta", lambda x: np.clip(x, -2.0, 2.0)),
}


@pytest.mark.parametrize("alarm", CASES)
def test_every_fault_is_named(alarm):
    values = fault_free()
    name, change = CASES[alarm]
    values[name][FAULT] = change(values[name][FAULT])
    found = failing(values)
    assert 4000 <= found[alarm] <= 4600
    assert set(found) - {alarm} <= {"resolver_mismatch"}


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
