"""When a recording holds enough to be judged: sensors, targets and their pace, and since when something lacks."""

import numpy as np
import pytest

from tierod.core.findings import Status
from tierod.monitors.condition.coverage import (
    HELD,
    LOST,
    UNASKED,
    Absence,
    Coverage,
    ImpossibleValues,
    TargetPace,
    all_zero,
)
from tierod.monitors.condition.signals import ALL_WHEELS, PLACES, SENSORS, TARGETS, ConditionSample

RATE = 100.0
NAMES = ConditionSample._fields
WHEELS = [NAMES.index(name) for name in ALL_WHEELS]


def columns(seconds=5.0, **changed):
    """All signals at 1, some of them changed."""
    count = round(seconds * RATE)
    values = np.ones((count, len(NAMES)))
    for name, value in changed.items():
        values[:, NAMES.index(name)] = value
    return values


def covered(values, cuts=()):
    coverage = Coverage(RATE)
    pieces = [coverage.add(piece) for piece in np.split(values, cuts)]
    result = [np.concatenate(parts) for parts in zip(*(covered for _, covered in pieces), strict=True)]
    return np.concatenate([kept for kept, _ in pieces]), result, coverage.interruptions


def test_with_all_signals_everything_is_judged():
    kept, (available, judged, zero, *_), interruptions = covered(columns())
    assert available.all()
    assert judged.all()
    assert not zero.any()
    assert interruptions == 0
    np.testing.assert_array_equal(kept, columns())


@pytest.mark.parametrize("place", range(len(SENSORS)))
def test_a_missing_sensor_is_not_available_and_the_rest_is_judged(place):
    _, (available, judged, *_), _ = covered(columns(**{SENSORS[place]: np.nan}))
    assert not available[:, place].any()
    assert np.delete(available, place, axis=1).all()
    assert judged.all()


@pytest.mark.parametrize("place", range(len(TARGETS)))
def test_without_a_target_nothing_is_judged(place):
    _, (available, judged, *_), interruptions = covered(columns(**{TARGETS[place]: np.nan}))
    assert not available[:, len(SENSORS) + place].any()
    assert not judged.any()
    assert interruptions == 0


def test_a_slow_channel_is_not_missing():
    yaw_rate = np.full(500, np.nan)
    yaw_rate[::10] = 0.1
    _, (available, judged, *_), _ = covered(columns(yaw_rate=yaw_rate))
    assert available.all()
    assert judged.all()


def test_what_falls_silent_is_lost_after_a_second_and_back_with_its_next_reading():
    values = columns(6.0)
    values[200:500, PLACES] = np.nan
    _, (available, judged, *_), interruptions = covered(values)
    last_judged = 199 + round(LOST * RATE)
    assert judged[: last_judged + 1].all()
    assert not judged[last_judged + 1 : 500].any()
    assert judged[500:].all()
    np.testing.assert_array_equal(available[:, 0], judged)
    assert interruptions == 1


def test_sensors_are_enough_from_the_first_reading_of_the_fourth_on():
    values = columns()
    values[:, PLACES] = np.nan
    for place, first in zip(PLACES[:5], (0, 0, 120, 200, 350), strict=True):
        values[first : first + 3, place] = 1.0
    whole = Coverage(RATE).add(values)[1].enough
    assert not whole[:200].any()
    assert whole[200:].all()
    pieces, coverage = np.array_split(values, 7), Coverage(RATE)
    np.testing.assert_array_equal(np.concatenate([coverage.add(each)[1].enough for each in pieces]), whole)


def test_zeros_of_all_sensors_are_no_readings():
    values = columns()
    values[300:, PLACES] = 0.0
    kept, (_, judged, zero, *_), interruptions = covered(values)
    assert np.isnan(kept[300:, PLACES]).all()
    assert (np.delete(kept[300:], PLACES, axis=1) == 1.0).all()
    assert zero.nonzero()[0].tolist() == list(range(300, 500))
    assert not judged[-1]
    assert interruptions == 1
    assert (values[300:, PLACES] == 0.0).all()


def lively(seconds, speed=8.0):
    """All signals change from sample to sample; the wheels turn."""
    count = round(seconds * RATE)
    values = np.sin(np.arange(count)[:, None] * 0.3 + np.arange(len(NAMES)) + 1.0)
    values[:, WHEELS] += speed
    return values


def test_readings_that_all_repeat_themselves_are_no_readings():
    values = lively(5.0)
    values[300:, PLACES] = values[300, PLACES]
    kept, result, _ = covered(values)
    first = 300 + round(HELD * RATE)
    assert result[3].nonzero()[0].tolist() == list(range(first, 500))
    assert np.isnan(kept[first:, PLACES]).all()
    np.testing.assert_array_equal(kept[:first], values[:first])
    assert not result[1][-1]


def test_one_sensor_that_goes_on_is_enough_not_to_be_held():
    values = lively(5.0)
    values[300:, PLACES[:-1]] = values[300, PLACES[:-1]]
    assert not covered(values)[1][3].any()


def test_without_a_target_judgement_ends_before_a_sensor_is_blamed():
    values = columns()
    values[200:, NAMES.index(TARGETS[0])] = np.nan
    _, (_, judged, *_), interruptions = covered(values)
    assert np.flatnonzero(~judged)[0] == 200 + round(UNASKED * RATE)
    assert interruptions == 1


@pytest.mark.parametrize(("last", "stands"), [(8.0, False), (1.0, True)])
def test_a_vehicle_whose_wheel_speeds_end_is_parked_where_it_was_about_to_stand(last, stands):
    values = columns(**dict.fromkeys(ALL_WHEELS, last))
    values[300:400, WHEELS], values[400:, WHEELS] = 0.0, np.nan
    parked = covered(values)[1][4]
    assert (parked == stands).all()


def test_a_vehicle_that_never_moved_is_parked():
    assert covered(columns(**dict.fromkeys(ALL_WHEELS, 0.0)))[1][4].all()


def test_a_single_sensor_that_reads_zero_is_left_to_the_monitor():
    assert not all_zero(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.1]])).any()
    assert all_zero(np.array([[0.0, 0.0, 0.0, np.nan, 0.0, 0.0]])).all()
    assert not all_zero(np.array([[0.0, 0.0, np.nan, np.nan, np.nan, np.nan]])).any()


@pytest.mark.parametrize("cuts", [(1,), (150, 250), (299, 300, 301), (450,)])
def test_the_result_does_not_depend_on_the_cuts(cuts):
    values = lively(7.0)
    values[:30] = np.nan
    values[30:40, WHEELS], values[650:, PLACES] = 0.0, values[650, PLACES]
    values[140:450, PLACES] = np.nan
    values[500:640, NAMES.index(TARGETS[2])] = np.nan
    whole, pieces = covered(values), covered(values, cuts)
    np.testing.assert_array_equal(pieces[0], whole[0])
    for one, other in zip(pieces[1], whole[1], strict=True):
        np.testing.assert_array_equal(one, other)
    assert pieces[2] == whole[2] == 2


PLACE = ConditionSample._fields.index("lateral_acceleration")


def test_what_is_impossible_is_left_out_counted_and_named():
    values = np.ones((10, len(ConditionSample._fields)))
    values[2, PLACE], values[3, PLACE], values[4, 0] = 1e300, -np.inf, np.inf
    checked = ImpossibleValues()
    kept = checked.add(values[:3]), checked.add(values[3:])
    cleaned = np.vstack(kept)
    assert np.argwhere(np.isnan(cleaned)).tolist() == [[2, PLACE], [3, PLACE], [4, 0]]
    assert (cleaned[np.isfinite(cleaned)] == 1.0).all()
    wheel, lateral = checked.notes()
    assert wheel.startswith("1 impossible value of wheel speed rear left, up to inf m/s was left out")
    assert lateral.startswith("2 impossible values of lateral acceleration, up to inf m/s**2 were left out")


def test_a_fault_of_a_sensor_and_a_missing_value_are_not_impossible():
    values = np.full((5, len(ConditionSample._fields)), 20.0)
    values[1, PLACE] = np.nan
    checked = ImpossibleValues()
    assert checked.add(values) is values
    assert checked.notes() == ()


TARGET_PLACES = [ConditionSample._fields.index(name) for name in TARGETS]


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
    (problem,) = result(every(5, TARGET_PLACES), piece)
    assert "are sampled at 20 Hz" in problem.cause
    assert all(name in problem.action for name in TARGETS)


def test_one_slow_target_is_named():
    (problem,) = result(every(4, TARGET_PLACES[2:3]))
    assert f"{TARGETS[2]} is sampled at 25 Hz" in problem.cause
    assert TARGETS[0] not in problem.action


def test_targets_at_half_the_rate_are_fast_enough_and_so_are_slow_sensors():
    assert result(every(2, TARGET_PLACES)) == ()
    assert result(every(10, range(6))) == ()


def test_gaps_and_lost_frames_are_no_slow_target():
    values = rows()
    values[np.ix_(np.random.default_rng(3).random(len(values)) < 0.2, TARGET_PLACES)] = np.nan
    values[500:900, TARGET_PLACES] = np.nan
    assert result(values) == ()
    values[:, TARGET_PLACES] = np.nan
    assert result(values) == ()


PERIOD, BORNE = 0.01, 1.0
TIME = np.arange(3000) * PERIOD


def followed(there, parked=None, cuts=(), others=None):
    absence = Absence(PERIOD, BORNE)
    parked = np.zeros(len(TIME), bool) if parked is None else parked
    rest = np.zeros(len(TIME), bool) if others is None else others
    for time, some, stands, each in zip(*(np.split(each, cuts) for each in (TIME, there, parked, rest)), strict=True):
        absence.add(time, some, stands, each)
    return absence


@pytest.mark.parametrize("cuts", [(), (700, 1500), (1100, 1101)])
def test_what_ends_is_gone_since_its_last_reading(cuts):
    absence = followed(TIME < 11.0 - 1e-9, cuts=cuts)
    assert absence.since == pytest.approx(10.0)
    assert absence.loss(Status.NOT_AVAILABLE, "no reading", "read").cause == "no reading since 10.00 s"


def test_what_comes_back_has_lacked_for_most_of_the_drive_or_not():
    rare, often = followed((TIME < 5.0) | (TIME > 25.0)), followed((TIME < 10.0) | (TIME > 15.0))
    assert (rare.since, often.since) == (None, None)
    assert rare.loss(Status.NOT_AVAILABLE, "", "read").cause == "read for only 10 of 30 s of driving"
    assert often.loss(Status.NOT_AVAILABLE, "", "read") is None


@pytest.mark.parametrize("cuts", [(), (700, 1500), (1100, 1101)])
def test_what_lacks_alone_and_comes_back_has_the_times_of_its_gap(cuts):
    there, alone = (TIME < 11.0 - 1e-9) | (TIME > 15.0 - 1e-9), np.ones(len(TIME), bool)
    gap = followed(there, cuts=cuts, others=alone).loss(Status.NOT_AVAILABLE, "no reading", "read")
    assert (gap.status, gap.cause) == (Status.NOT_TESTABLE, "no reading from 10.00 s to 15.00 s")
    # Where all signals pause together, nothing was judged, and none of them was lost.
    assert followed(there, cuts=cuts, others=there).loss(Status.NOT_AVAILABLE, "no reading", "read") is None


def test_nothing_lacks_while_the_vehicle_is_parked_nor_what_never_came():
    assert followed(TIME < 11.0, TIME > 10.5).loss(Status.NOT_AVAILABLE, "", "") is None
    assert followed(TIME < 0.0).loss(Status.NOT_AVAILABLE, "", "") is None


def test_a_short_end_is_no_loss():
    assert followed(TIME < 29.5).since is None
