"""Targets that are recorded too seldom are named, however the recording is cut; losses of some are not."""

import numpy as np
import pytest

from tierod.monitors.condition.coverage import TargetPace
from tierod.monitors.condition.signals import TARGETS, ConditionSample

RATE = 100.0
PLACES = [ConditionSample._fields.index(name) for name in TARGETS]


def result(values, piece=10_000):
    pace = TargetPace(RATE)
    for start in range(0, len(values), piece):
        pace.add(values[start : start + piece])
    return pace.problems()


def rows(count=3000):
    return np.zeros((count, len(ConditionSample._fields)))


def every(steps, columns):
    values = rows()
    seldom = np.arange(len(values)) % steps != 0
    values[np.ix_(seldom, columns)] = np.nan
    return values


@pytest.mark.parametrize("piece", [10_000, 7, 1])
def test_slow_targets_are_reported_with_their_rate_however_the_recording_is_cut(piece):
    (problem,) = result(every(5, PLACES), piece)
    assert "are sampled at 20 Hz" in problem.cause
    assert all(name in problem.action for name in TARGETS)


def test_one_slow_target_is_named():
    (problem,) = result(every(4, PLACES[2:3]))
    assert f"{TARGETS[2]} is sampled at 25 Hz" in problem.cause
    assert TARGETS[0] not in problem.action


def test_targets_at_half_the_rate_are_fast_enough_and_so_are_slow_sensors():
    assert result(every(2, PLACES)) == ()
    assert result(every(10, range(6))) == ()


def test_gaps_and_lost_frames_are_no_slow_target():
    values = rows()
    values[np.ix_(np.random.default_rng(3).random(len(values)) < 0.2, PLACES)] = np.nan
    values[500:900, PLACES] = np.nan
    assert result(values) == ()
    values[:, PLACES] = np.nan
    assert result(values) == ()
