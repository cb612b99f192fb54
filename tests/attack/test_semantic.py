"""Changes of one signal: a seeded sample of all cases, and those that were confidently wrong once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from attack.semantic import SEEDS, UNOBSERVABLE, Case, outcome, pairs, run, unchanged, wrong
from attack.semantic_drives import DRIVES
from tierod.monitors.registry import MONITORS

BY_NAME = {(drive.monitor, drive.name): drive for drive in DRIVES}

FAILED_ONCE = (
    ("friction", "step", "steering_wheel_rate", "stuck"),
    ("friction", "healthy", "driver_torque", "x2"),
    ("friction", "healthy", "motor_torque", "x2"),
    ("friction", "healthy", "motor_torque", "drift to two deviations"),
    ("friction", "healthy", "driver_torque", "gain that grows to 2"),
    ("hysteresis", "hoist", "driver_torque", "x2"),
    ("hysteresis", "hoist", "motor_torque", "x2"),
    ("hysteresis", "hoist", "driver_torque", "swap with motor_torque"),
    ("hysteresis", "worn", "motor_torque", "stuck"),
    ("driver-torque", "bench", "driver_torque", "x2"),
    ("driver-torque", "bench", "driver_torque", "stuck"),
    ("driver-torque", "bench", "motor_angle_mechanical", "drift to two deviations"),
    ("driver-torque", "bench", "motor_angle_mechanical", "offset"),
    ("driver-torque", "bench", "motor_angle_mechanical", "clip"),
    ("driver-torque", "road", "steering_wheel_angle", "late .5 s"),
    ("driver-torque", "road", "driver_torque", "late .1 s"),
    ("driver-torque", "road-gain", "motor_angle_mechanical", "dropped"),
    ("sideslip", "town-offset", "vehicle_speed", "noise"),
    ("sideslip", "town-offset", "vehicle_speed", "swap with motor_torque"),
    ("motor-angle", "bench", "motor_angle_mechanical", "noise"),
    ("motor-angle", "bench", "target_motor_angle_mechanical", "late .1 s"),
    ("motor-angle", "car", "driver_torque", "sign"),
    ("motor-angle", "car", "motor_current_alpha", "gain that grows to 2"),
    ("motor-angle", "car", "driver_torque", "dropped"),
    ("condition", "round", "lateral_acceleration", "stuck"),
    ("condition", "round", "longitudinal_acceleration", "sign"),
)
"""Cases with wrong words: monitor, recording, signal, change."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("semantic")


@pytest.mark.parametrize("most", [2, pytest.param(len(DRIVES), marks=pytest.mark.slow)])
@pytest.mark.parametrize("monitor", MONITORS)
def test_a_sample_of_changes_has_no_wrong_word(folder, monitor, most):
    count = min(most, sum(drive.monitor == monitor for drive in DRIVES))
    figures = run(count, 20261123, folder, [monitor], SEEDS[1:])[monitor]
    assert figures["cases"] == count
    assert figures["wrong_words"] == {}
    assert figures["defects"] == 0


@pytest.mark.parametrize(("monitor", "name", "signal", "change"), FAILED_ONCE)
def test_what_was_wrong_once_names_the_signal(folder, monitor, name, signal, change):
    case = Case(BY_NAME[monitor, name], ((signal, change),), SEEDS[1])
    found = outcome(case, folder)
    assert wrong(case, found) == "", found.text


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: f"{drive.monitor}-{drive.name}")
def test_unchanged_recordings_are_what_they_are_called(folder, drive):
    *_, code = unchanged(drive, SEEDS[1], folder)
    assert code == (1 if drive.faulty else 0)


def test_what_cannot_be_observed_stands_in_the_documentation():
    page = " ".join(
        (Path(__file__).parents[2] / "docs" / "explanation" / "reliability.md").read_text(encoding="utf-8").split()
    )
    for sentence in UNOBSERVABLE:
        assert sentence in page.replace("`", "")


@pytest.mark.slow
@pytest.mark.parametrize("monitor", MONITORS)
def test_no_change_at_all_has_a_wrong_word(folder, monitor):
    figures = run(10**6, 1, folder, [monitor])[monitor]
    assert figures["wrong_words"] == {}
    assert figures["defects"] == 0


@pytest.mark.parametrize("monitor", MONITORS)
def test_two_changed_signals_have_no_wrong_word(folder, monitor):
    drive = next(drive for drive in DRIVES if drive.monitor == monitor)
    for case in pairs(drive, SEEDS[1], folder, 2, np.random.default_rng(20261129)):
        found = outcome(case, folder)
        assert wrong(case, found) == "", f"{case.name}: {found.text}"
