"""Wrong signs are named from the data, right ones never."""

import numpy as np
import pytest

from monitors.driver_torque.swept_runs import run
from tierod.core.graph import scan
from tierod.monitors.driver_torque.block import ColumnSigns, wrong_signs

NAMES = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
BLOCK = ColumnSigns(18.0)


@pytest.mark.parametrize("hands", ["steps", "ramps", "free"])
def test_right_signs_are_judged_and_never_named(hands):
    found = scan(BLOCK, run(hands)[0])
    assert not any(found[name].any() for name in NAMES)
    assert found["angles_judged"][-1] == found["torque_judged"][-1] == found["motor_judged"][-1] == 1.0


@pytest.mark.parametrize("wrong", range(4))
@pytest.mark.parametrize("hands", ["ramps", "free"])
def test_a_wrong_sign_is_named(hands, wrong):
    samples = run(hands)[0].copy()
    samples[:, wrong] *= -1.0
    found = scan(BLOCK, samples)
    named = [name for name in NAMES if found[name].any()]
    assert named == [NAMES[wrong]]
    (sentence,) = wrong_signs(found.at(-1))
    assert sentence.startswith(f"{NAMES[wrong]} has the wrong sign")


def test_offsets_and_missing_samples_do_not_matter():
    samples = run("free")[0] * np.array([1.0, 1.0, 1.0, -1.0]) + np.array([0.0, 0.5, -2.0, 0.1])
    samples[np.random.default_rng(0).random(samples.shape) < 0.05] = np.nan
    found = scan(BLOCK, samples)
    assert np.isfinite(found.values).all()
    assert [name for name in NAMES if found[name][-1]] == ["driver_torque"]


def test_rest_is_not_judged():
    samples = np.random.default_rng(0).normal(size=(3_000, 4)) * 1e-3
    assert not scan(BLOCK, samples).values.any()


@pytest.mark.parametrize("late", [1, 3, 5, 10, 20])
def test_a_late_angle_of_the_motor_is_not_taken_for_a_reversed_torque(late):
    samples = run("free")[0].copy()
    samples[late:, 2] = samples[:-late, 2]
    assert not scan(BLOCK, samples)["driver_torque"].any()


@pytest.mark.parametrize("ratio", [17.0, 19.0])
def test_a_wrong_ratio_is_not_taken_for_a_reversed_torque(ratio):
    assert not scan(ColumnSigns(ratio), run("free")[0])["driver_torque"].any()
