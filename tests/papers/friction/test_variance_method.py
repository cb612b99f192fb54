"""The paper's baseline: observer, gate, rolling variance, and what it concludes over a recording."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.friction_paper import CAR
from papers.friction.drives import driven
from tierod.core.graph import scan
from tierod.core.statuses import Status
from tierod.monitors.friction.signals import SteeringSample
from tierod_lab.papers.friction.joint_model import rate_hold
from tierod_lab.papers.friction.variance_method import (
    RollingVariance,
    VarianceFrictionMonitor,
    VarianceGate,
    VarianceParameters,
)
from tierod_lab.papers.friction.variance_session import NEEDED_WINDOWS, VarianceSession

COMMON = {name: getattr(CAR, name) for name in set(CAR.__dataclass_fields__) & set(VarianceParameters.__annotations__)}
PARAMETERS = VarianceParameters(
    **COMMON, front_cornering_stiffness=110e3, rear_cornering_stiffness=130e3, nominal_friction=4.0
)
UNGATED = VarianceFrictionMonitor(PARAMETERS, threshold=math.inf, gate=None)
WINDOW = UNGATED.block_samples * UNGATED.blocks


def variances(monitor, friction, seed=1):
    run = scan(monitor, driven(friction, seed))
    return run["variance"][run["ready"] > 0.0]


def test_the_observer_has_its_triple_pole():
    decay, gain = rate_hold(0.01, 0.8, 0.1)
    system = np.array([[1.0, 0.01, 0.0], [0.0, decay, -gain / 15.5], [0.0, 0.0, 1.0]])
    closed = (np.eye(3) - np.outer(UNGATED.observer_gains(), [1.0, 0.0, 0.0])) @ system
    pole = math.exp(-0.15)
    assert np.poly(closed) == pytest.approx([1.0, -3.0 * pole, 3.0 * pole**2, -(pole**3)], abs=1e-9)


def test_the_observer_finds_a_constant_aligning_torque():
    run = scan(UNGATED, np.tile(SteeringSample(0.5, 0.0, 3.0, 0.1, 0.0, 0.0, 20.0), (200, 1)))
    assert run["internal_torque"][-1] == pytest.approx((3.0 + 2.0) * 15.5, rel=1e-3)


def test_variance_rises_with_friction_and_a_threshold_from_healthy_drives_separates():
    healthy, more, faulty = (variances(UNGATED, friction) for friction in (4.0, 8.0, 12.5))
    assert 500.0 < np.median(healthy) < 2500.0
    assert 3000.0 < np.median(more) < 5500.0
    assert 9000.0 < np.median(faulty) < 16000.0
    monitor = replace(UNGATED, threshold=float(healthy.max()))
    held_out, found = scan(monitor, driven(4.0, 3)), scan(monitor, driven(12.5, 1))
    assert np.mean(held_out["fault"][held_out["ready"] > 0.0]) < 0.02
    assert np.mean(found["fault"][found["ready"] > 0.0]) > 0.98


def test_the_printed_sign_compares_the_torque_with_its_negative():
    literal = replace(UNGATED, literal_sign=True)
    assert np.median(variances(literal, 4.0)) > 3.0 * np.median(variances(UNGATED, 4.0))
    found, expected = (scan(each, driven(4.0, 1))["external_torque"] for each in (literal, UNGATED))
    np.testing.assert_allclose(found, -expected, rtol=1e-6, equal_nan=False)


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
def test_each_condition_of_the_printed_gate(angle, acceleration, slip, opened):
    assert VarianceGate().opened(angle, acceleration, slip) == opened


@pytest.mark.parametrize("column", [0, 2, 6])
def test_a_missing_signal_is_left_out_and_harms_nothing(column):
    samples = driven(4.0, 1).values[6000:9000].copy()
    samples[1000:1300, column] = np.nan
    run = scan(UNGATED, samples)
    assert np.all(run["enabled"][1000:1300] == 0.0)
    assert np.all(np.isfinite(run["internal_torque"]))
    assert np.all(np.isfinite(run.state.values))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3), st.floats(0.0, 1.0))
def test_is_the_variance_of_the_counted_samples_of_whole_blocks(seed, offset, share):
    random = np.random.default_rng(seed)
    values = random.standard_normal(100) + offset
    counted = (random.random(100) < share).astype(float)
    run = scan(RollingVariance(block_samples=7, blocks=3), np.column_stack([values, counted]))
    for end in range(100):
        stop = (end + 1) // 7 * 7
        window = slice(max(stop - 21, 0), stop)
        kept = values[window][counted[window] > 0.0]
        assert run["samples"][end] == len(kept)
        expected = np.var(kept, ddof=1) if len(kept) >= 2 else 0.0
        assert run["variance"][end] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def concluded(windows, variance, enabled=1.0):
    session = VarianceSession("friction, baseline", replace(UNGATED, threshold=1000.0), 100.0)
    count = windows * WINDOW
    result = {
        "ready": np.ones(count),
        "variance": np.full(count, variance),
        "enabled": (np.arange(count) < enabled * count).astype(float),
    }
    for piece in np.array_split(np.arange(count), 3):
        session.collect(piece / 100.0, {}, {name: values[piece] for name, values in result.items()})
    return session.conclude().verdict


def test_the_share_of_the_time_that_was_enabled_is_that_of_all_samples():
    found = concluded(8, 500.0, 0.25)
    assert found.status is Status.HEALTHY
    assert found.evidence["enabled_share"] == pytest.approx(0.25, abs=1e-3)
    assert found.evidence["windows"] == 8.0
    assert concluded(8, 1e5).status is Status.FAULT


def test_too_few_windows_are_said_with_the_share():
    found = concluded(NEEDED_WINDOWS - 1, 500.0, 0.4)
    assert found.status is Status.NOT_READY
    assert "40.0% of the drive" in found.cause
