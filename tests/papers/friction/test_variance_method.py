from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from models.friction_paper import CAR
from papers.friction.drives import driven
from tierod.core.errors import InputError, ParameterError
from tierod.core.graph import scan
from tierod.monitors.friction.signals import SteeringSample
from tierod_lab.papers.friction.joint_model import rate_hold
from tierod_lab.papers.friction.variance_method import (
    VarianceFrictionMonitor,
    VarianceGate,
    VarianceParameters,
    calibrated,
)

PARAMETERS = VarianceParameters(
    mass=CAR.mass,
    front_distance=CAR.front_distance,
    rear_distance=CAR.rear_distance,
    front_cornering_stiffness=110e3,
    rear_cornering_stiffness=130e3,
    trail=CAR.trail,
    steering_ratio=CAR.steering_ratio,
    column_inertia=CAR.column_inertia,
    column_damping=CAR.column_damping,
    motor_ratio=CAR.motor_ratio,
    nominal_friction=4.0,
)
UNGATED = VarianceFrictionMonitor(PARAMETERS, threshold=math.inf, gate=None)


def variances(monitor: VarianceFrictionMonitor, friction: float, seed: int) -> np.ndarray:
    run = scan(monitor, driven(friction, seed))
    return run["variance"][run["ready"] > 0.0]


def test_the_observer_has_its_triple_pole():
    decay, gain = rate_hold(0.01, 0.8, 0.1)
    system = np.array([[1.0, 0.01, 0.0], [0.0, decay, -gain / 15.5], [0.0, 0.0, 1.0]])
    gains = np.array(UNGATED.observer_gains())
    closed = (np.eye(3) - np.outer(gains, [1.0, 0.0, 0.0])) @ system
    pole = math.exp(-0.15)
    assert np.poly(closed) == pytest.approx([1.0, -3.0 * pole, 3.0 * pole**2, -(pole**3)], abs=1e-9)


def test_the_observer_finds_a_constant_aligning_torque():
    state = UNGATED.init()
    for _ in range(200):
        state, output = UNGATED.step(state, SteeringSample(0.5, 0.0, 3.0, 0.1, 0.0, 0.0, 20.0))
    assert output.internal_torque == pytest.approx((3.0 + 2.0) * 15.5, rel=1e-3)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_variance_rises_with_friction_on_clean_drives(seed):
    medians = [np.median(variances(UNGATED, friction, seed)) for friction in (4.0, 8.0, 12.5)]
    assert 500.0 < medians[0] < 2500.0
    assert 3000.0 < medians[1] < 5500.0
    assert 9000.0 < medians[2] < 16000.0


def test_a_threshold_from_healthy_drives_separates_clean_drives():
    healthy = [scan(UNGATED, driven(4.0, seed)) for seed in (1, 2)]
    monitor = calibrated(UNGATED, healthy, quantile=1.0)
    held_out, faulty = scan(monitor, driven(4.0, 3)), scan(monitor, driven(12.5, 1))
    assert np.mean(held_out["fault"][held_out["ready"] > 0.0]) < 0.02
    assert np.mean(faulty["fault"][faulty["ready"] > 0.0]) > 0.98


def test_the_printed_sign_compares_the_torque_with_its_negative():
    literal = replace(UNGATED, literal_sign=True)
    right, wrong = (np.median(variances(monitor, 4.0, 1)) for monitor in (UNGATED, literal))
    assert wrong > 3.0 * right
    drive = driven(4.0, 1)
    found, expected = (scan(each, drive)["external_torque"] for each in (literal, UNGATED))
    np.testing.assert_allclose(found, -expected, rtol=1e-6, equal_nan=False)


def test_the_printed_gate_opens_seldom():
    run = scan(replace(UNGATED, gate=VarianceGate()), driven(4.0, 1))
    assert 0.005 < np.mean(run["enabled"]) < 0.06


@pytest.mark.parametrize(
    ("angle", "acceleration", "slip", "opened"),
    [
        (0.3, 0.3, 0.01, 1.0),
        (-0.3, -0.3, -0.01, 1.0),
        (0.17, 0.3, 0.01, 0.0),
        (0.3, 0.1, 0.01, 0.0),
        (0.3, 0.5, 0.01, 0.0),
        (0.3, 0.3, 0.09, 0.0),
        (math.nan, 0.3, 0.01, 0.0),
    ],
)
def test_each_condition_of_the_gate(angle, acceleration, slip, opened):
    assert VarianceGate().opened(angle, acceleration, slip) == opened


@pytest.mark.parametrize("column", range(7))
def test_a_missing_signal_is_left_out_and_harms_nothing(column):
    samples = driven(4.0, 1).values[6000:9000].copy()
    samples[1000:1300, column] = np.nan
    run = scan(UNGATED, samples)
    assert np.all(run["enabled"][1000:1300] == 0.0)
    assert np.all(np.isfinite(run["internal_torque"]))
    assert np.all(np.isfinite(run["variance"]))
    assert np.all(np.isfinite(run.state.values))


def test_standstill_does_not_count():
    samples = np.zeros((2000, 7))
    run = scan(UNGATED, samples)
    assert np.all(run["enabled"] == 0.0)
    assert np.all(run["ready"] == 0.0)
    assert np.all(np.isfinite(run["external_torque"]))


def test_calibration_needs_windows_and_a_sensible_quantile():
    empty = scan(UNGATED, np.zeros((2000, 7)))
    with pytest.raises(InputError, match="gate never opened"):
        calibrated(UNGATED, [empty], 0.99)
    with pytest.raises(ParameterError, match="expected 0.5 to 1"):
        calibrated(UNGATED, [empty], 99.0)
