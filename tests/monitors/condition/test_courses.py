"""Statements over the samples of a recording: episodes of faults, courses of trouble codes, and kinds in words."""

import numpy as np
import pytest

from monitors.condition.made_up_statements import PERIOD, declare, doubt, fault_free, part, place, span
from tierod.core.findings import Status
from tierod.core.units import known
from tierod.monitors.condition.courses import (
    FAULT,
    NOT_AVAILABLE,
    NOT_TESTABLE,
    SUSPECT,
    ElementCourse,
    StatementCourse,
    described,
)
from tierod.monitors.condition.kinds import DELAY, DRIFT, GAIN, LOSS, LOST_TORQUE, NOISE, OFFSET, OUTLIER, STUCK
from tierod.monitors.condition.signals import ELEMENTS, OF_AUTOMATED


@pytest.mark.parametrize(
    ("element", "kind", "size", "words"),
    [
        ("yaw_rate", LOSS, np.nan, ("total loss", "", "")),
        ("yaw_rate", STUCK, np.nan, ("stuck", "", "")),
        ("yaw_rate", OFFSET, 0.3, ("positive offset", "offset", "rad/s")),
        ("tie_rod_force", OFFSET, -0.3, ("negative offset", "offset", "N")),
        ("steering_shaft_torque", GAIN, 1.5, ("wrong gain", "reading over truth", "")),
        ("yaw_rate", DRIFT, 0.01, ("drift", "growth of the error", "rad/s**2")),
        ("tie_rod_force", DRIFT, 0.01, ("drift", "growth of the error", "N/s")),
        ("yaw_rate", OUTLIER, 3.0, ("outlier", "reading over truth", "")),
        ("wheel_speed_rear_left", NOISE, 0.5, ("noise", "standard deviation of the noise", "m/s")),
        ("yaw_rate", DELAY, 0.2, ("delay", "delay", "s")),
        ("steering_motor_1", LOST_TORQUE, 0.5, ("loss of torque", "lost share of the torque", "percent")),
        ("yaw_rate", 0.0, np.nan, ("", "", "")),
    ],
)
def test_every_kind_has_words_quantity_and_unit(element, kind, size, words):
    assert tuple(described(element, kind, size))[:3] == words


@pytest.mark.parametrize("sensor", OF_AUTOMATED)
def test_every_unit_is_one_that_is_known(sensor):
    assert known(described(sensor, DRIFT, 1.0).unit)


def test_what_is_not_there_is_neither_doubted_nor_testable_but_stays_declared():
    for state, expected in ((SUSPECT, [NOT_AVAILABLE, SUSPECT]), (FAULT, [FAULT, FAULT])):
        _, stated = fault_free(0.02)
        stated.status[:] = state
        there = np.ones((2, len(ELEMENTS)), bool)
        there[0, place("yaw_rate")] = False
        seen = stated.where_available(there, np.ones(len(there), bool))
        assert seen.status[:, place("yaw_rate")].tolist() == expected
        assert seen.testable[:, place("yaw_rate")].tolist() == [False, True]


def test_at_standstill_nothing_is_testable():
    _, stated = fault_free(0.02)
    seen = stated.where_available(np.ones((2, len(ELEMENTS)), bool), np.array([True, False]))
    assert seen.testable.any(axis=1).tolist() == [True, False]


def test_nothing_is_stated_about_what_is_not_judged():
    stated = StatementCourse.unjudged(3)
    assert stated.status.shape == (3, len(ELEMENTS))
    assert (stated.status == NOT_TESTABLE).all()
    assert not stated.testable.any()


YAW, ANGLE = "yaw_rate", "steering_wheel_angle"


def course_of(time, stated, element=YAW, available=True, cuts=()):
    course = ElementCourse(element, PERIOD)
    there = np.full(len(time), available) if isinstance(available, bool) else available
    for start, stop in zip((0, *cuts), (*cuts, len(time)), strict=True):
        course.add(time[start:stop], part(stated, start, stop), there[start:stop])
    return course


def episodes_of(time, stated, **more):
    return course_of(time, stated, **more).episodes(float(time[-1]) + PERIOD)


def test_a_fault_free_element_has_no_episode_and_was_testable_all_the_time():
    course = course_of(*fault_free(10.0))
    assert course.episodes(10.0) == ()
    assert course.testable == pytest.approx(10.0)
    assert [change.status for change in course.course] == [Status.HEALTHY]


def test_an_episode_has_start_end_kind_and_size():
    time, stated = fault_free()
    declare(stated, span(2.0, 5.0), (YAW,), OFFSET, -0.3)
    (episode,) = episodes_of(time, stated)
    assert (episode.start, episode.end) == (pytest.approx(2.0), pytest.approx(5.0))
    assert episode.kind == "negative offset"
    assert (episode.magnitude.quantity, episode.magnitude.value, episode.magnitude.unit) == (
        "offset of yaw rate",
        -0.3,
        "rad/s",
    )
    assert episode.candidates == ()


@pytest.mark.parametrize("cuts", [(), (400,)])
def test_an_episode_has_no_kind_where_none_was_identified_for_longer_than_any(cuts):
    time, stated = fault_free()
    for start, stop, kind in ((2.0, 3.9, 0.0), (3.9, 5.5, GAIN), (5.5, 7.0, OFFSET)):
        declare(stated, span(start, stop), (YAW,), kind, 0.2)
    (episode,) = episodes_of(time, stated, cuts=cuts)
    assert (episode.kind, episode.magnitude) == ("", None)


@pytest.mark.parametrize("cuts", [(), (450,)])
def test_of_two_kinds_reported_for_as_long_cuts_choose_none(cuts):
    time, stated = fault_free()
    for start, stop, kind in ((2.0, 4.0, NOISE), (4.0, 6.0, OFFSET)):
        declare(stated, span(start, stop), (YAW,), kind, 0.2)
    assert episodes_of(time, stated, cuts=cuts)[0].kind == "positive offset"


def test_what_lasts_to_the_end_has_no_end():
    time, stated = fault_free()
    declare(stated, span(8.0, 10.0), (YAW,))
    assert episodes_of(time, stated)[0].end is None


def test_the_kind_is_the_one_reported_for_longest_and_not_that_of_the_return():
    time, stated = fault_free()
    for start, stop, kind, magnitude in ((2.0, 2.1, GAIN, 4.0), (2.1, 4.9, OFFSET, 0.2), (4.9, 5.0, NOISE, 9.0)):
        declare(stated, span(start, stop), (YAW,), kind, magnitude)
    (episode,) = episodes_of(time, stated)
    assert (episode.kind, episode.magnitude.value) == ("positive offset", 0.2)


@pytest.mark.parametrize(("gap", "count"), [(0.2, 1), (0.5, 2)])
def test_episodes_with_little_between_them_are_one(gap, count):
    time, stated = fault_free()
    declare(stated, span(2.0, 3.0), (YAW,))
    declare(stated, span(3.0 + gap, 4.0), (YAW,))
    found = episodes_of(time, stated)
    assert len(found) == count
    assert found[-1].end == pytest.approx(4.0)


def test_lasting_doubt_names_the_others_and_short_doubt_is_not_reported():
    time, stated = fault_free()
    doubt(stated, span(2.0, 3.0), (YAW, ANGLE))
    doubt(stated, span(5.0, 5.3), (YAW, ANGLE))
    (episode,) = episodes_of(time, stated)
    assert episode.candidates == (ANGLE,)
    assert (episode.start, episode.end) == (pytest.approx(2.0), pytest.approx(3.0))


def test_doubt_of_one_alone_on_the_way_to_a_verdict_is_no_episode():
    time, stated = fault_free()
    doubt(stated, span(2.0, 3.0), (YAW,))
    assert episodes_of(time, stated) == ()


def test_the_course_shows_every_change_once():
    time, stated = fault_free()
    stated.testable[span(0.0, 1.0)] = False
    doubt(stated, span(2.0, 2.5), (YAW,))
    declare(stated, span(2.5, 4.0), (YAW,))
    there = np.ones(len(time), bool)
    there[span(6.0, 7.0)] = False
    course = course_of(
        time,
        stated.where_available(np.repeat(there[:, None], stated.status.shape[1], axis=1), np.ones(len(time), bool)),
        available=there,
    )
    expected = [
        (0.0, Status.NOT_TESTABLE),
        (1.0, Status.HEALTHY),
        (2.0, Status.SUSPECT),
        (2.5, Status.FAULT),
        (4.0, Status.HEALTHY),
        (6.0, Status.NOT_AVAILABLE),
        (7.0, Status.HEALTHY),
    ]
    assert [(pytest.approx(change.time), change.status) for change in course.course] == expected
    assert course.available == pytest.approx(9.0)
    assert course.testable == pytest.approx(8.0)


@pytest.mark.parametrize("cuts", [(1,), (250, 251), (260,), (100, 350, 520, 999)])
def test_the_result_does_not_depend_on_the_cuts(cuts):
    time, stated = fault_free()
    rng = np.random.default_rng(1)
    column = place(YAW)
    for at in (span(2.5, 5.2), span(5.3, 6.0)):
        declare(stated, at, (YAW,))
    stated.kind[:, column] = rng.choice([OFFSET, GAIN], len(time), p=[0.7, 0.3])
    stated.magnitude[:, column], stated.deviation[:, column] = rng.normal(size=len(time)), 0.1
    doubt(stated, span(7.0, 8.0))
    whole, pieces = course_of(time, stated), course_of(time, stated, cuts=cuts)
    assert pieces.episodes(10.0) == whole.episodes(10.0)
    assert pieces.course == whole.course
    assert (pieces.testable, pieces.available) == (whole.testable, whole.available)


def test_what_was_declared_while_something_else_was_wrong_is_taken_back():
    time, stated = fault_free()
    for start, stop in ((1.0, 2.0), (4.0, 5.0), (7.0, 8.0)):
        declare(stated, span(start, stop), (YAW,))
    course = course_of(time, stated)
    course.forget(3.5, 6.0)
    assert [each.start for each in course.episodes(10.0)] == pytest.approx([1.0, 7.0])
    statuses = [(each.status, each.time) for each in course.course if each.status is not Status.HEALTHY]
    assert [status for status, _ in statuses] == [Status.FAULT, Status.NOT_TESTABLE, Status.FAULT]
    assert [start for _, start in statuses] == pytest.approx([1.0, 4.0, 7.0])
