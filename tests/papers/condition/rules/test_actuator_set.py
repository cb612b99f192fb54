import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.core.graph import scan
from tierod.monitors.condition.signals import ConditionSample
from tierod_lab.papers.condition.rules.actuator_set import actuator_set
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.parameters import ACTUATOR_RESIDUALS, RESIDUALS, Coefficients
from tierod_lab.papers.condition.rules.residual_set import residual_set

KNOWN = Coefficients(1.0, 1.0, 0.1, 0.5, 0.4, 0.1, 0.2, 100.0, 0.5, 10.0, 1e-3, 0.01, 400.0, 50.0, 0.3, 200.0)
BLOCK = AllResiduals(residual_set(CAR, KNOWN), actuator_set(CAR, KNOWN))


def index(name):
    return ConditionSample._fields.index(name)


def targeted(**changed):
    samples = circle(seconds=4.0)
    samples[:, index("target_steering_wheel_angle")] = samples[:, index("steering_wheel_angle")]
    for name, value in changed.items():
        samples[:, index(name)] = value
    return samples


@pytest.mark.parametrize("name", [each.name for each in ACTUATOR_RESIDUALS])
def test_a_residual_changes_with_its_signals_and_with_no_others(name):
    random = np.random.default_rng(2)
    samples = targeted(steering_motor_1_target_torque=3.0, steering_motor_2_target_torque=2.0)
    samples[:, index("target_drive_torque_left")] = samples[:, index("target_drive_torque_right")] = 20.0
    samples[:, index("steering_shaft_torque")] = 3.0  # about the torque estimated from the motion of the steering
    samples += 0.01 * random.normal(size=samples.shape)
    base = scan(BLOCK, samples)[f"residuals.{name}"]
    seen = set()
    for column, signal in enumerate(ConditionSample._fields):
        other = samples.copy()
        other[200:, column] += 0.1 * random.normal(size=200)
        if not np.array_equal(scan(BLOCK, other)[f"residuals.{name}"], base):
            seen.add(signal)
    assert seen == set(RESIDUALS[name].signals)


def test_targets_that_are_met_leave_no_residual():
    result = scan(BLOCK, targeted())
    for name, size in {"r1a": 0.02, "r3a": 0.1, "r4a": 0.1, "r5a": 1e-9, "r7a": 0.05}.items():
        assert result[f"residuals.{name}"][-1] == pytest.approx(0.0, abs=size), name


def test_a_motor_without_torque_is_reported_by_its_own_target():
    samples = targeted()
    split = np.where(np.arange(len(samples)) % 24 < 12, 0.65, 0.35)
    samples[:, index("steering_motor_1_target_torque")] = 4.0 * split
    samples[:, index("steering_motor_2_target_torque")] = 4.0 * (1.0 - split)
    samples[:, index("steering_shaft_torque")] = 4.0 * (1.0 - split) + KNOWN.torque_offset
    plain = Coefficients(torque_offset=KNOWN.torque_offset)
    result = scan(AllResiduals(residual_set(CAR, plain), actuator_set(CAR, plain)), samples)
    assert result["residuals.motor_1_share"][-1] == pytest.approx(1.0, abs=0.2)
    assert result["residuals.motor_2_share"][-1] == pytest.approx(0.0, abs=0.2)


def test_a_jump_of_the_asked_torque_is_not_compared():
    samples = targeted()
    samples[200:, index("steering_motor_1_target_torque")] = 5.0
    there = scan(BLOCK, samples)["there.r6a"]
    assert there[199] == 1.0
    assert not there[200:202].any()
    assert there[-1] == 1.0
