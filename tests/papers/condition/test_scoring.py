"""Scores of hand-made diagnoses: every figure against one worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tierod.core.recording import Channel, Recording
from tierod_lab.papers.condition.drives import LOSS, OFFSET, Drive, Injected
from tierod_lab.papers.condition.scoring import FOUND, MISSED, NOT_TESTABLE, DriveScore
from tierod_lab.papers.condition.scoring import score as score_of
from tierod_lab.papers.condition.summary import confusion, isolated, summary
from tierod_lab.papers.condition.truth import Declared, truth_of, where_shown

YAW, ANGLE = "yaw_rate", "steering_wheel_angle"
TIME = np.arange(6000) / 100.0


def _between(start: float, end: float) -> np.ndarray:
    return (start - 1e-9 <= TIME) & (end - 1e-9 > TIME)


def _recording(true: np.ndarray, read: np.ndarray) -> Recording:
    """The yaw rate of the nominal vehicle, whose sensor has an offset of 0.002 rad/s, and an angle of zero."""
    values = {YAW: read, f"truth_{YAW}": true, ANGLE: 0.0 * TIME, f"truth_{ANGLE}": 0.0 * TIME}
    return Recording({name: Channel(name, TIME, each, "rad/s") for name, each in values.items()})


def score(drive: Drive, recording: Recording, declared: Declared) -> DriveScore:
    return score_of(drive, truth_of(drive, recording), declared)


def _lost() -> tuple[Drive, Recording]:
    """A yaw rate of 0.5 rad/s that is lost from 20 to 40 s, and is zero in truth from 30 to 35 s."""
    true = np.where(_between(30.0, 35.0), 0.0, 0.5)
    read = np.where(_between(20.0, 40.0), 0.0, true + 0.002)
    return Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),)), _recording(true, read)


def test_a_fault_found_late_and_given_up_while_it_is_not_identifiable():
    drive, recording = _lost()
    said = _between(20.3, 30.1) | _between(35.2, 40.5)
    found = score(drive, recording, Declared(TIME, {YAW: said}))
    fault = found.faults[0]
    # Late by 0.3 s, given up for 5.1 s, held 0.5 s too long.
    assert fault.accuracy == pytest.approx(1.0 - 5.9 / 60.0)
    # From 30.1 s (0.1 s of memory and a mean square) to 35 s the fault is not observable.
    assert fault.accuracy_excused == pytest.approx(1.0 - 1.0 / 55.1, abs=2e-3)
    assert (fault.outcome, fault.delay) == (FOUND, pytest.approx(0.3))
    assert fault.shown == pytest.approx(15.1, abs=0.03)
    assert (found.wrong_share, found.false_alarms) == (0.0, 0)
    assert found.named == YAW


def test_a_wrong_name_is_counted_by_time_and_does_not_find_the_fault():
    drive, recording = _lost()
    found = score(drive, recording, Declared(TIME, {ANGLE: _between(22.0, 32.0)}))
    assert found.wrong_share == pytest.approx(0.5)
    assert found.faults[0].outcome == MISSED
    assert found.false_alarms == 0
    assert math.isinf(found.faults[0].delay)


def test_declarations_outside_faults_are_false_alarms_but_for_a_late_return():
    drive, recording = _lost()
    flags = _between(5.0, 5.2) | _between(7.0, 7.1) | _between(20.0, 41.0) | _between(41.5, 41.6) | _between(50.0, 50.1)
    found = score(drive, recording, Declared(TIME, {YAW: flags}))
    assert found.false_alarms == 3
    assert found.healthy_hours == pytest.approx(40.0 / 3600.0)
    assert found.flagged_share == pytest.approx(0.4 / 40.0)


def test_time_in_which_a_fault_does_not_show_is_no_delay():
    true = np.where(_between(20.0, 20.3) | _between(25.0, 40.0), 0.5, 0.0)
    read = np.where(_between(20.0, 40.0), 0.0, true)
    drive, recording = Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),)), _recording(true, read)
    said, doubts = _between(25.2, 40.0), _between(20.1, 25.2)
    fault = score(drive, recording, Declared(TIME, {YAW: said}, {YAW: doubts, ANGLE: doubts})).faults[0]
    assert fault.delay == pytest.approx(5.2)
    assert fault.delay_shown == pytest.approx(5.2, abs=0.02)
    # 0.3 s and 0.2 s, and the 0.1 s over which the first moment is remembered.
    assert fault.delay_excited == pytest.approx(0.6, abs=0.03)
    assert fault.delay_suspected == pytest.approx(0.1, abs=0.02)


def test_a_declaration_before_anything_shows_has_a_delay_below_zero():
    true = np.where(_between(22.0, 40.0), 0.5, 0.0)
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),))
    recording = _recording(true, np.where(_between(20.0, 40.0), 0.0, true))
    early = score(drive, recording, Declared(TIME, {YAW: _between(20.5, 40.0)})).faults[0]
    assert early.delay_shown == pytest.approx(-1.5, abs=0.05)
    assert early.outcome == FOUND


def test_by_the_noise_of_a_sensor_a_smaller_fault_shows_than_by_what_is_asked_of_the_diagnosis():
    """Yaw rate: 0.003 rad/s of white noise, 0.1 s at 100 Hz: three deviations of the mean are 0.0028 rad/s."""
    for size, strict in ((0.0026, NOT_TESTABLE), (0.0031, MISSED)):
        read = np.where(_between(20.0, 40.0), size, 0.0)
        drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, OFFSET, size),))
        bias = drive.driven.sensors[YAW].bias
        fault = score(drive, _recording(0.0 * TIME, bias + read), Declared(TIME, {})).faults[0]
        assert (fault.outcome, fault.strict.outcome) == (NOT_TESTABLE, strict)


def test_the_strict_figures_are_those_of_the_strict_grade():
    true = np.where(_between(22.0, 40.0), 0.5, 0.0) + np.where(_between(20.0, 22.0), 0.02, 0.0)
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),))
    recording = _recording(true, np.where(_between(20.0, 40.0), 0.0, true))
    found = summary([score(drive, recording, Declared(TIME, {YAW: _between(22.2, 40.0)}))])
    assert found.strict.delays == pytest.approx([2.2], abs=0.05)
    assert found.delays_shown == pytest.approx([0.2], abs=0.05)
    assert (found.strict.missed, found.strict.not_testable) == (0, 0)
    assert found.strict.worst < found.worst_excused


def test_a_fault_that_never_shows_is_not_missed():
    true = 0.0 * TIME
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),))
    fault = score(drive, _recording(true, true), Declared(TIME, {})).faults[0]
    assert fault.outcome == NOT_TESTABLE
    assert fault.accuracy_excused == 1.0


def test_kind_and_size_are_judged_two_seconds_after_the_declaration():
    true = 0.0 * TIME
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, OFFSET, 0.3),))
    recording = _recording(true, 0.002 + np.where(_between(20.0, 40.0), 0.3, 0.0))
    kind = np.where(TIME < 22.05, "gain", OFFSET)
    size = np.where(TIME < 22.05, 9.0, 0.33)
    value = np.where(_between(20.1, 40.0), 0.012, 5.0)
    declared = Declared(TIME, {YAW: _between(20.1, 40.0)}, kind={YAW: kind}, size={YAW: size}, value={YAW: value})
    fault = score(drive, recording, declared).faults[0]
    assert fault.kind_right
    assert fault.size_error == pytest.approx(0.1)
    assert fault.size_covered is None
    assert fault.rmse == pytest.approx(0.01)
    assert fault.delay_shown == pytest.approx(0.1)


@pytest.mark.parametrize(("deviation", "covered"), [(0.02, True), (0.01, False)])
def test_the_interval_of_a_size_holds_it_or_not(deviation, covered):
    true = 0.0 * TIME
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, OFFSET, 0.3),))
    there = _between(20.0, 40.0)
    kind, size, deviations = (
        np.where(there, value, other) for value, other in ((OFFSET, ""), (0.33, 0.0), (deviation, 0.0))
    )
    declared = Declared(TIME, {YAW: there}, kind={YAW: kind}, size={YAW: size}, deviation={YAW: deviations})
    found = score(drive, _recording(true, 0.002 + np.where(there, 0.3, 0.0)), declared)
    assert found.faults[0].size_covered is covered
    assert summary([found]).covered == float(covered)
    wrong = declared._replace(kind={YAW: np.where(there, "gain", "")})
    assert score(drive, _recording(true, true), wrong).faults[0].size_covered is None


@pytest.mark.parametrize(
    ("declared", "verdict"),
    [
        ({YAW: 1, ANGLE: 1}, "right"),
        ({YAW: 1}, "partial"),
        ({"tie_rod_force": 1, YAW: 1}, "wrong"),
        ({}, "nothing"),
    ],
)
def test_two_faults_at_once_are_right_partly_right_or_wrong(declared, verdict):
    pair = (Injected(YAW, OFFSET, 0.3), Injected(ANGLE, OFFSET, 1.5, start=22.0))
    recording = _recording(0.0 * TIME, np.where(_between(20.0, 40.0), 0.302, 0.002))
    angle = Channel(ANGLE, TIME, np.where(_between(22.0, 40.0), 1.5, 0.0), "rad")
    recording = recording.with_channels([angle])
    flags = {name: _between(22.3, 40.0) for name in declared}
    found = score(Drive("short-round", 60.0, 0, injected=pair), recording, Declared(TIME, flags))
    assert getattr(isolated([found]), verdict) == 1.0


def test_candidates_alone_are_ambiguous():
    drive, recording = _lost()
    said = {YAW: _between(20.1, 40.0), ANGLE: _between(20.1, 40.0)}
    found = score(drive, recording, Declared(TIME, {}, candidates=said))
    assert isolated([found]).ambiguous == 1.0
    assert confusion([found]) == {YAW: {"ambiguous": 1}}


def test_figures_of_several_drives():
    drive, recording = _lost()
    good = score(drive, recording, Declared(TIME, {YAW: _between(20.1, 40.0)}))
    bad = score(drive, recording, Declared(TIME, {ANGLE: _between(20.0, 40.0) | _between(50.0, 51.0)}))
    figures = summary([good, bad])
    assert figures.missed == 1
    assert figures.wrong == pytest.approx(0.5)
    assert figures.false_alarms == 1
    assert figures.worst == pytest.approx(1.0 - 20.0 / 60.0)
    assert figures.accuracy == pytest.approx(1.0 - 20.1 / 120.0)
    # Garwood's bound after one event is 4.744.
    assert figures.bound == pytest.approx(4.744 / (80.0 / 3600.0), rel=1e-3)
    np.testing.assert_allclose(figures.delays, [0.1], atol=1e-9)


def test_a_constant_deviation_shows_above_three_standard_deviations():
    there = np.ones(300, bool)
    assert not where_shown(YAW, np.full(300, 0.029), there).any()
    assert where_shown(YAW, np.full(300, 0.031), there)[9:].all()
    assert not where_shown(YAW, np.full(300, 0.031), ~there).any()


def test_a_sensor_that_is_back_cannot_be_distinguished_from_a_lost_one_while_it_reads_nothing():
    true = np.where(_between(40.0, 45.0), 0.0, 0.5)
    read = np.where(_between(20.0, 40.0), 0.0, true + 0.002)
    drive = Drive("short-round", 60.0, 0, injected=(Injected(YAW, LOSS),))
    fault = score(drive, _recording(true, read), Declared(TIME, {YAW: _between(20.0, 46.0)})).faults[0]
    assert fault.accuracy == pytest.approx(1.0 - 6.0 / 60.0)
    assert fault.accuracy_excused == pytest.approx(1.0 - 1.1 / 55.1, abs=3e-3)
    offset = Drive("short-round", 60.0, 0, injected=(Injected(YAW, OFFSET, 0.3),))
    fault = score(offset, _recording(true, read), Declared(TIME, {YAW: _between(20.0, 46.0)})).faults[0]
    assert fault.accuracy_excused == pytest.approx(fault.accuracy)


def test_what_is_said_from_a_sample_on_keeps_all_columns_in_step():
    said = {YAW: TIME}
    later = Declared(TIME, *(said for _ in Declared._fields[1:])).since(4000)
    assert all((getattr(later, name)[YAW] == later.time).all() for name in Declared._fields[1:])
    assert later.time[0] == TIME[4000]
