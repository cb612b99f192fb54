"""Accelerations beside the motion: closed forms, what fails is found, what is fault-free is not, in any cuts."""

from itertools import pairwise

import numpy as np
import pytest

from monitors.condition.demonstrator import CAR, circle
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.accelerations import BLOCK, BOUNDS, AccelerationCheck, Blocks, Motion, motion_of
from tierod.monitors.condition.signals import ACCELERATIONS, ConditionSample
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.recorded import recorded

PARAMETERS = load("smartload").parameters_for(AutomatedVehicle.Parameters)
RATE = 100.0
BOTH = ("wheel_speed_rear_left", "wheel_speed_rear_right")


def signals(columns):
    return dict(zip(ConditionSample._fields, columns.T.copy(), strict=True))


def blocks(*pieces):
    """Ends of the blocks, and the motion in each."""
    cutter, ends, found, start = Blocks(RATE), [], [], 0
    for piece in pieces:
        count = len(piece[BOTH[0]])
        cut, own = cutter.add((start + np.arange(count)) / RATE, piece)
        found += [motion_of(cut, cutter, PARAMETERS)] if own else []
        ends, start = ends + own, start + count
    return ends, Motion(*(np.concatenate(each, axis=-1) for each in zip(*found, strict=True)))


def straight(slope, seconds=5.0):
    """A straight drive whose speed grows evenly."""
    time = np.arange(round(seconds * RATE)) / RATE
    moving = signals(np.zeros((len(time), len(ConditionSample._fields))))
    return moving | dict.fromkeys(BOTH, PARAMETERS.wheel_speed_scale * (5.0 + slope * time))


def test_a_circle_has_yaw_rate_times_speed_across_and_the_centripetal_part_along():
    ends, found = blocks(signals(circle(20.0, 6.0)))
    assert ends == pytest.approx([0.5 * number for number in range(1, 11)])
    np.testing.assert_allclose(found.moved[1], 0.3 * 6.0, rtol=0.06)
    np.testing.assert_allclose(found.moved[0], -0.09 * CAR.rear_distance, atol=0.01)


def test_along_counts_the_slope_of_the_speed():
    _, found = blocks(straight(1.3))
    np.testing.assert_allclose(found.moved, np.repeat([[1.3], [0.0]], 10, axis=1), atol=1e-9)
    assert not found.rough.any()


def test_the_result_does_not_depend_on_the_cuts():
    whole = straight(1.3)
    parts = [
        {name: values[start:stop] for name, values in whole.items()} for start, stop in ((0, 33), (33, 333), (333, 500))
    ]
    (ends, found), (again, same) = blocks(*parts), blocks(whole)
    assert ends == again
    for one, other in zip(found, same, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("wrong", ["yaw_rate", "steering_wheel_angle"])
def test_one_wrong_yaw_rate_of_three_does_not_matter(wrong):
    _, found = blocks(signals(circle(20.0, 6.0, **{wrong: -2.0})))
    assert found.moved[1, 5] == pytest.approx(0.3 * 6.0, rel=0.06)


def test_wheels_that_disagree_show_nothing():
    _, found = blocks(signals(circle(20.0, 6.0, wheel_speed_rear_left=0.0)))
    assert np.isnan(found.moved[:, 5]).all()
    assert np.isnan(found.speed[5])


def test_a_vehicle_that_stands_or_reverses_predicts_nothing():
    for factor in (0.0, -1.0):
        moved = straight(0.0)
        moved |= {name: factor * moved[name] for name in BOTH}
        assert np.isnan(blocks(moved)[1].moved[:, 3]).all()


def test_wheel_speeds_at_twenty_hertz_do():
    sparse = straight(1.3)
    for name in BOTH:
        sparse[name][np.arange(500) % 5 != 0] = np.nan
    ends, found = blocks(sparse)
    assert found.moved[0, 4] == pytest.approx(1.3)
    assert len(ends) == round(5.0 / BLOCK)


ALONG, ACROSS = ACCELERATIONS
SINCE = 20.0


@pytest.fixture(scope="module")
def drive():
    recording = recorded(Drive("short-round", 45.0, 2, 7701))
    return recording["yaw_rate"].time, {
        name: recording[name].values for name in ConditionSample._fields if name in recording
    }


def check(drive, cuts=(), **changed):
    time, signals = drive
    signals = signals | {name: np.where(time < SINCE, signals[name], values) for name, values in changed.items()}
    made = AccelerationCheck(PARAMETERS, 100.0)
    edges, failed = [0, *cuts, len(time)], {}
    for start, stop in pairwise(edges):
        here = made.add(time[start:stop], {name: values[start:stop] for name, values in signals.items()})
        failed |= {name: start + first for name, first in here.items()}
    return made, failed


CHANGES = {
    "stuck": lambda values: np.full_like(values, values[2000]),
    "sign": lambda values: -values,
    "twice": lambda values: 2.0 * values,
    "half": lambda values: 0.5 * values,
    "off": lambda values: values + 2.46,
    "late": lambda values: np.roll(values, 50),
    "noisy": lambda values: values + 2.0 * np.random.default_rng(1).standard_normal(len(values)),
    "clipped": lambda values: np.clip(values, -1.0, 1.0),
}


def test_fault_free_accelerations_go_with_the_motion(drive):
    made, failed = check(drive)
    assert (made.found, failed) == ({}, {})


@pytest.mark.parametrize("name", ACCELERATIONS)
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_one_that_fails_is_found_and_no_other(drive, name, change):
    made, failed = check(drive, **{name: change(drive[1][name])})
    assert set(made.found) == set(failed) == {name}
    found = made.found[name]
    assert found.sure
    assert made.gone(name)
    assert SINCE - 0.5 <= found.start <= found.found <= SINCE + 15.0
    assert found.window <= found.start
    assert drive[0][failed[name]] == pytest.approx(found.found, abs=0.011)


def near_the_limit(drive):
    """Signals whose rear wheels and steering angle indicate half as much yaw rate again, as where tyres slip."""
    signals = dict(drive[1])
    left, right = signals["wheel_speed_rear_left"], signals["wheel_speed_rear_right"]
    middle, half = 0.5 * (left + right), 0.5 * (right - left)
    return signals | {
        "wheel_speed_rear_left": middle - 1.8 * half,
        "wheel_speed_rear_right": middle + 1.8 * half,
        "steering_wheel_angle": 1.8 * signals["steering_wheel_angle"],
    }


def test_the_yaw_rate_sensor_alone_vouches_for_a_lateral_acceleration_where_tyres_slip(drive):
    made, _ = check((drive[0], near_the_limit(drive)))
    assert ACROSS not in made.found


@pytest.mark.parametrize("change", ["stuck", "sign", "off"])
def test_a_lateral_acceleration_that_no_yaw_rate_explains_is_found_all_the_same(drive, change):
    made, _ = check((drive[0], near_the_limit(drive)), **{ACROSS: CHANGES[change](drive[1][ACROSS])})
    assert made.gone(ACROSS)


def test_a_soft_body_and_the_slip_of_its_rear_tyres_are_no_fault(drive):
    time, signals = drive
    moved = signals["yaw_rate"] * 0.5 * (signals["wheel_speed_rear_left"] + signals["wheel_speed_rear_right"])
    known = np.isfinite(moved)
    moved = np.interp(time, time[known], moved[known]) / PARAMETERS.wheel_speed_scale
    moved = np.convolve(moved, np.ones(20) / 20.0, "same")
    leaning = 1.15 * moved - 0.12 * np.gradient(moved, 0.01)
    made, _ = check((time, signals | {ACROSS: leaning}))
    assert ACROSS not in made.found
    rigid = AccelerationCheck(PARAMETERS, 100.0, across=BOUNDS)
    rigid.add(time, signals | {ACROSS: leaning})
    assert ACROSS in rigid.found, "it is what a stiff car never shows"


def test_swapped_ones_are_both_found(drive):
    made, _ = check(drive, **{ALONG: drive[1][ACROSS], ACROSS: drive[1][ALONG]})
    assert set(made.found) == {ALONG, ACROSS}


def test_a_missing_one_is_not(drive):
    made, _ = check(drive, **{ALONG: np.full(len(drive[0]), np.nan)})
    assert made.found == {}


def test_a_little_is_a_doubt(drive):
    made, failed = check(drive, **{ACROSS: drive[1][ACROSS] + 1.1})
    assert not made.found[ACROSS].sure
    assert failed == {}


@pytest.mark.parametrize("cuts", [(2050,), (7, 2033, 2034, 2700)])
def test_no_failure_depends_on_the_cuts(drive, cuts):
    whole, first = check(drive, **{ALONG: -drive[1][ALONG]})
    parts, again = check(drive, cuts, **{ALONG: -drive[1][ALONG]})
    assert parts.found == whole.found
    assert again == first


def test_a_pause_that_was_skipped_leaves_the_times_right(drive):
    time, signals = drive
    later = np.where(time < SINCE - 5.0, time, time + 3600.0)
    made, failed = check((later, signals | {ALONG: np.where(time < SINCE, signals[ALONG], -signals[ALONG])}))
    found = made.found[ALONG]
    assert SINCE - 0.5 <= found.start - 3600.0 <= found.found - 3600.0 <= SINCE + 15.0
    assert later[failed[ALONG]] == pytest.approx(found.found, abs=0.011)
