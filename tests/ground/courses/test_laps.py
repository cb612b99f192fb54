"""Courses driven by the virtual car with its driver."""

from dataclasses import replace

import numpy as np
import pytest

from tierod_lab.ground import scenarios
from tierod_lab.ground.cars.eps_car import EpsCar
from tierod_lab.ground.courses import load
from tierod_lab.ground.run import run

HALF_LANE = 0.5 * (3.5 - 1.8)
"""Room on either side of a car of 1.8 m in a lane of 3.5 m [m]."""


def load_seeded(seed):
    return replace(load("drawn-round"), seed=seed)


def driven(course, seconds=None):
    outcome = run(EpsCar(), course, seconds)
    assert outcome.diverged_at is None
    return {name: channel.values for name, channel in outcome.recording.channels.items()}


@pytest.mark.parametrize("name", ["short-round", "long-round", "third-round"])
def test_a_lap_of_a_round_stays_in_the_lane(name):
    course = load(name)
    truth = driven(course, 90.0)
    assert truth["truth_distance"][-1] > course.length
    assert np.max(np.abs(truth["truth_lateral_offset"])) < HALF_LANE
    planned = np.interp(
        np.arange(len(truth["truth_distance"])) * 0.01, np.arange(4500) * 0.02, course.plan.distance[:4500]
    )
    assert np.max(np.abs(truth["truth_distance"] - planned)) < 6.0
    assert np.max(np.abs(truth["truth_centre_lateral_acceleration"])) > 0.9 * course.lateral_acceleration


def test_a_round_comes_back_to_its_start():
    course = load("short-round")
    truth = driven(course, 60.0)
    back = int(np.argmax(truth["truth_distance"] >= course.length))
    assert np.hypot(truth["truth_position_x"][back], truth["truth_position_y"][back]) < 1.0
    assert truth["truth_heading"][back] == pytest.approx(2.0 * np.pi, abs=0.2)


def test_other_seeds_draw_other_rounds_and_the_same_seed_the_same():
    one, same, other = (load_seeded(seed) for seed in (3, 3, 4))
    place = np.linspace(0.0, 200.0, 400)
    ways = [each.columns(place, place, 8.0, 1.0)["road.curvature"] for each in (one, same, other)]
    assert np.array_equal(ways[0], ways[1])
    assert not np.allclose(ways[0], ways[2])
    assert one.duration == 600.0
    assert one.start.speed == 0.0


def test_the_demonstrator_keeps_its_lane_on_a_drawn_round():
    outcome = scenarios.load("demonstrator-healthy").with_run(seconds=60.0, seed=2).run()
    truth = outcome.recording
    assert outcome.diverged_at is None
    assert truth["truth_speed"].values.max() > 6.0
    assert np.max(np.abs(truth["truth_lateral_offset"].values)) < 1.0


def test_a_city_drive_halts_and_goes_on_in_its_lane():
    truth = driven(load("city"), 240.0)
    resting = np.abs(truth["truth_speed"]) < 0.05
    assert resting[:200].all(), "begins at rest"
    assert np.sum(np.diff(resting.astype(int)) == 1) >= 1, "halts again"
    assert truth["truth_speed"].max() > 8.0
    assert np.max(np.abs(truth["truth_lateral_offset"])) < HALF_LANE


@pytest.mark.parametrize("name", ["slalom", "iso-3888-double-lane-change"])
def test_cones_stay_up(name):
    assert np.max(np.abs(driven(load(name))["truth_lateral_offset"])) < 0.6


def test_hands_off_is_no_torque():
    course = load("straight-hands-off")
    truth = driven(course, 11.0)
    free = slice(650, 950)
    assert np.std(truth["truth_hand_torque"][free]) < 0.2, "tremor is all that is left"
    quiet = driven(type(course)(conditions=course.conditions[2:]), 11.0)
    assert not quiet["truth_hand_torque"][free].any()
