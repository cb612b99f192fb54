"""Scores of hand-made diagnoses: every figure against one worked out by hand."""

import math

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod_lab.papers.condition.drives import LOSS, OFFSET, Drive, Injected
from tierod_lab.papers.condition.scoring import Declared, scored, truth_of, where_shown

YAW, ANGLE = "yaw_rate", "steering_wheel_angle"
TIME = np.arange(6000) / 100.0
STILL = 0.0 * TIME


def between(start, end):
    return (start - 1e-9 <= TIME) & (end - 1e-9 > TIME)


def rows(true, read, declared, *faults):
    """The yaw rate of the nominal vehicle, whose sensor has an offset of 0.002 rad/s, and an angle."""
    angle = np.where(between(22.0, 40.0), 1.5, 0.0) if len(faults) > 1 else STILL
    values = {YAW: read, f"truth_{YAW}": true, ANGLE: angle, f"truth_{ANGLE}": STILL}
    recording = Recording({name: Channel(name, TIME, each, "rad/s") for name, each in values.items()})
    drive = Drive("short-round", 60.0, 0, injected=faults or (Injected(YAW, LOSS),))
    return scored(drive, truth_of(drive, recording), declared)


LOST_TRUE = np.where(between(30.0, 35.0), 0.0, 0.5)
LOST_READ = np.where(between(20.0, 40.0), 0.0, LOST_TRUE + 0.002)


def lost(declared):
    """A yaw rate of 0.5 rad/s that is lost from 20 to 40 s, and is zero in truth from 30 to 35 s."""
    return rows(LOST_TRUE, LOST_READ, declared)[0]


def test_a_fault_found_late_and_given_up_while_it_is_not_identifiable():
    row = lost(Declared(TIME, {YAW: between(20.3, 30.1) | between(35.2, 40.5)}))
    # Late by 0.3 s, given up for 5.1 s, held 0.5 s too long.
    assert row["accuracy"] == pytest.approx(1.0 - 5.9 / 60.0)
    # From 30.1 s (0.1 s of memory and a mean square) to 35 s the fault is not observable.
    assert row["observable_accuracy"] == pytest.approx(1.0 - 1.0 / 55.1, abs=2e-3)
    assert (row["outcome"], row["delay"]) == ("found", pytest.approx(0.3))
    assert row["shown"] == pytest.approx(15.1, abs=0.03)
    assert (row["wrong"], row["alarms"], row["named"], row["isolated"]) == (0.0, 0.0, YAW, "right")
    assert (row["strict_missed"], row["strict_delay"]) == (0.0, pytest.approx(0.3, abs=0.02))


def test_a_wrong_name_is_counted_by_time_and_does_not_find_the_fault():
    row = lost(Declared(TIME, {ANGLE: between(22.0, 32.0)}))
    assert (row["wrong"], row["outcome"], row["alarms"]) == (pytest.approx(0.5), "missed", 0.0)
    assert math.isinf(row["delay"])


def test_declarations_outside_faults_are_false_alarms_but_for_a_late_return():
    flags = between(5.0, 5.2) | between(7.0, 7.1) | between(20.0, 41.0) | between(41.5, 41.6) | between(50.0, 50.1)
    row = lost(Declared(TIME, {YAW: flags}))
    assert (row["alarms"], row["hours"]) == (3.0, pytest.approx(40.0 / 3600.0))


def test_time_in_which_a_fault_does_not_show_is_no_delay():
    true = np.where(between(20.0, 20.3) | between(25.0, 40.0), 0.5, 0.0)
    doubts = between(20.1, 25.2)
    declared = Declared(TIME, {YAW: between(25.2, 40.0)}, {YAW: doubts, ANGLE: doubts})
    (row,) = rows(true, np.where(between(20.0, 40.0), 0.0, true), declared)
    assert row["delay"] == pytest.approx(5.2)
    assert row["delay_shown"] == pytest.approx(5.2, abs=0.02)
    # 0.3 s and 0.2 s, and the 0.1 s over which the first moment is remembered.
    assert row["delay_excited"] == pytest.approx(0.6, abs=0.03)
    assert row["suspected"] == pytest.approx(0.1, abs=0.02)


def test_a_fault_that_never_shows_is_not_missed():
    (row,) = rows(STILL, STILL, Declared(TIME, {}))
    assert (row["outcome"], row["missed"], row["observable_accuracy"]) == ("never", 0.0, 1.0)


@pytest.mark.parametrize(("deviation", "covered"), [(0.02, 1.0), (0.01, 0.0)])
def test_kind_size_and_substitute_are_judged_two_seconds_after_the_declaration(deviation, covered):
    early = TIME < 22.05
    declared = Declared(
        TIME,
        {YAW: between(20.1, 40.0)},
        kind={YAW: np.where(early, "gain", OFFSET)},
        size={YAW: np.where(early, 9.0, 0.33)},
        value={YAW: np.where(between(20.1, 40.0), 0.012, 5.0)},
        deviation={YAW: np.full(6000, deviation)},
    )
    read = 0.002 + np.where(between(20.0, 40.0), 0.3, 0.0)
    (row,) = rows(STILL, read, declared, Injected(YAW, OFFSET, 0.3))
    assert (row["kind_right"], row["covered"]) == (1.0, covered)
    assert row["size_error"] == pytest.approx(0.1)
    assert row["replaced"] == pytest.approx(1.0)  # 0.01 of 0.01 rad/s
    wrong = declared._replace(kind={YAW: np.full(6000, "gain")})
    assert "covered" not in rows(STILL, read, wrong, Injected(YAW, OFFSET, 0.3))[0]


@pytest.mark.parametrize(
    ("named", "isolated"),
    [((YAW, ANGLE), "right"), ((YAW,), "partial"), (("tie_rod_force", YAW), "wrong"), ((), "nothing")],
)
def test_two_faults_at_once_are_right_partly_right_or_wrong(named, isolated):
    declared = Declared(TIME, dict.fromkeys(named, between(22.3, 40.0)))
    pair = Injected(YAW, OFFSET, 0.3), Injected(ANGLE, OFFSET, 1.5, 22.0)
    found = rows(STILL, np.where(between(20.0, 40.0), 0.302, 0.002), declared, *pair)
    assert [row["isolated"] for row in found] == [isolated] * 2
    assert [row["hours"] > 0.0 for row in found] == [True, False], "a drive's hours count once"


def test_a_constant_deviation_shows_above_three_standard_deviations():
    there = np.ones(300, bool)
    assert not where_shown(np.full(300, 0.029), there, 0.01).any()
    assert where_shown(np.full(300, 0.031), there, 0.01)[9:].all()
    assert not where_shown(np.full(300, 0.031), ~there, 0.01).any()
