"""Accelerations beside the motion: what fails is found, what is fault-free is not, however the recording is cut."""

from itertools import pairwise

import numpy as np
import pytest

from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.monitors.condition.accelerations import BOUNDS, AccelerationCheck
from tierod.monitors.condition.signals import ACCELERATIONS, ConditionSample
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import Drive
from tierod_lab.papers.condition.recorded import recorded

PARAMETERS = load("smartload").parameters_for(AutomatedVehicle.Parameters)
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
def test_the_result_does_not_depend_on_the_cuts(drive, cuts):
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
