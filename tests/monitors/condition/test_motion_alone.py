"""A car with motion sensors alone: faults are named while they last, and slip of its tyres is none."""

import pytest

from monitors.condition.motion_alone import (
    FRONT_WHEELS,
    LASTING,
    MOTION,
    SETS,
    declared,
    drive,
    excerpts,
    hard,
    judged,
    outcome,
    with_slip,
)
from tierod.monitors.condition.definition import rolling_monitor
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import DRIFT, OFFSET, STUCK

SEED = 3
LATE = {STUCK: 1.5, DRIFT: 4.5, OFFSET: 0.1}
"""Longest time from the deviation that shows to the declaration [s]."""


@pytest.fixture(scope="module")
def bank():
    return rolling_monitor(load("rav4"))


@pytest.fixture(scope="module")
def parts():
    return excerpts(drive(SEED, 120.0), 3, SEED)


@pytest.mark.parametrize("kind", LATE)
@pytest.mark.parametrize("sensor", ["wheel_speed_rear_left", "wheel_speed_front_right"])
def test_a_wheel_is_named_while_its_fault_lasts_and_nothing_else(bank, parts, sensor, kind):
    found = [outcome(bank, part, sensor, kind) for part in parts]
    shown = [each for each in found if each.shows > 1.0]
    assert shown
    assert all(each.kind == kind and each.declared - each.onset < LATE[kind] for each in shown)
    assert not any(each.wrong for each in found)
    assert all(not each.error > 0.15 for each in shown)


def test_a_drift_of_the_steering_angle_that_a_bend_might_be_has_no_other_kind(bank, parts):
    found = [outcome(bank, part, "steering_wheel_angle", DRIFT) for part in parts]
    assert any(each.declared < LASTING for each in found)
    assert {each.kind for each in found} <= {"", DRIFT}


@pytest.mark.parametrize("only", SETS)
def test_nothing_is_declared_on_a_fault_free_drive_with_any_set_of_sensors(bank, only):
    assert not declared(judged(bank, drive(SEED, 120.0), SETS[only]))


@pytest.mark.parametrize("driven", ["front", "rear"])
@pytest.mark.parametrize("share", [0.0, 0.1])
def test_slip_under_drives_and_brakes_is_no_fault(bank, driven, share):
    part = with_slip(hard(SEED, driven, 60.0), share, driven)
    assert part["longitudinal_acceleration"].values.max() > 2.0
    assert part["longitudinal_acceleration"].values.min() < -3.0
    for only in (MOTION, SETS["four wheel speeds alone"]):
        assert not declared(judged(bank, part, only))


def test_four_wheel_speeds_alone_show_a_wheel_that_jumps(bank, parts):
    found = outcome(bank, parts[0], FRONT_WHEELS[0], OFFSET, SETS["four wheel speeds alone"])
    assert found.declared < 0.5
    assert not found.wrong
