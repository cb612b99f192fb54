"""The gains of the two torques follow from how the assist bends."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tierod.monitors.friction.evidence import GainsOverDrive
from tierod.monitors.registry import MONITORS
from tierod.vehicles import load
from tierod_lab.ground import FrictionCourse, drive

REQUIRED = MONITORS["friction"].required


@pytest.fixture(scope="module")
def signals() -> dict[str, np.ndarray]:
    aligned = drive(minutes=5.0, seed=11, scatter=True).align(REQUIRED, 100.0)
    return dict(zip(REQUIRED, aligned.values.T, strict=True))


def after(signals: dict[str, np.ndarray], vehicle=None) -> GainsOverDrive:
    gains = GainsOverDrive(vehicle or load("midsize-eps"), 100.0)
    gains.add(signals)
    return gains


@pytest.mark.parametrize(("driver", "motor"), [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0), (0.5, 1.0), (1.0, 0.5), (2.5, 2.5)])
def test_each_gain_is_found_beside_the_other(signals, driver, motor):
    fault_free = after(signals).found()
    scaled = signals | {
        "driver_torque": driver * signals["driver_torque"],
        "motor_torque": motor * signals["motor_torque"],
    }
    gains = after(scaled)
    assert gains.found().driver == pytest.approx(driver * fault_free.driver, rel=0.2)
    assert gains.found().motor == pytest.approx(motor * fault_free.motor, rel=0.2)
    named = {name for defect in gains.defects() for name in defect.rests_on}
    wrong = {name for name, gain in (("driver_torque", driver), ("motor_torque", motor)) if gain != 1.0}
    assert named == wrong


def test_an_offset_is_no_gain(signals):
    gains = after(signals | {"driver_torque": signals["driver_torque"] + 0.4})
    assert gains.found().driver == pytest.approx(1.0, abs=0.3)
    assert gains.defects() == ()


@pytest.fixture(scope="module")
def long_drive() -> dict[str, np.ndarray]:
    """A drive whose friction doubles in its middle."""
    aligned = drive(minutes=10.0, friction=FrictionCourse.step(4.0, 8.0, 300.0), seed=12).align(REQUIRED, 100.0)
    return dict(zip(REQUIRED, aligned.values.T, strict=True))


def creeping(values: np.ndarray, gain: float = 1.0, offset: float = 0.0) -> np.ndarray:
    """A signal whose gain and zero move evenly over the second half."""
    share = np.clip(np.linspace(-1.0, 1.0, len(values)), 0.0, 1.0)
    return values * (1.0 + (gain - 1.0) * share) + offset * share


@pytest.mark.parametrize(
    ("name", "gain", "offset"),
    [("driver_torque", 1.5, 0.0), ("motor_torque", 1.5, 0.0), ("driver_torque", 1.0, 1.0), ("motor_torque", 1.0, 0.3)],
)
def test_a_gain_or_a_zero_that_creeps_is_named_though_the_map_is_a_guess(long_drive, name, gain, offset):
    known = load("midsize-eps")
    wide = dataclasses.replace(known.parameters["assist_linear_gain"], standard_deviation=0.6)
    guessed = dataclasses.replace(known, parameters={**known.parameters, "assist_linear_gain": wide})
    (defect,) = after(long_drive | {name: creeping(long_drive[name], gain, offset)}, guessed).defects()
    assert name in defect.rests_on
    assert "at the beginning of the drive for the same driver_torque" in defect.cause
