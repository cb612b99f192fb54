"""Statements over the samples of a recording, and faults in words."""

import numpy as np
import pytest

from monitors.condition.made_up_statements import fault_free, place
from tierod.core.units import known
from tierod.monitors.condition.courses import (
    FAULT,
    NOT_AVAILABLE,
    NOT_TESTABLE,
    SUSPECT,
    StatementCourse,
    described,
)
from tierod.monitors.condition.kinds import (
    DELAY,
    DRIFT,
    GAIN,
    LOSS,
    LOST_TORQUE,
    NOISE,
    OFFSET,
    OUTLIER,
    STUCK,
)
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
