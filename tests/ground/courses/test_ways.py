"""Geometry and pace of circuits, natural roads and lanes, and what a car makes of them."""

import math

import numpy as np
import pytest

from tierod_lab.ground.cars.road_cars import EpsCar
from tierod_lab.ground.courses import load
from tierod_lab.ground.courses.manoeuvres import DoubleLaneChange
from tierod_lab.ground.courses.roads import Bend, Circuit, City, Country, Motorway, NaturalDrive, Straight
from tierod_lab.ground.courses.way import STEP, TICK, Pace, Way
from tierod_lab.ground.run import run

ROUNDS = ("short-round", "long-round", "third-round")


@pytest.mark.parametrize("name", ROUNDS)
def test_a_round_closes(name):
    course = load(name)
    curvature, _ = course.lap
    forward, left, heading = drawn(np.append(curvature, curvature[0]), course.length / len(curvature))
    assert math.hypot(forward[-1], left[-1]) < 0.1
    assert abs(heading[-1]) == pytest.approx(2.0 * math.pi, abs=1e-3)


def drawn(curvature: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates [m] and heading [rad] of every point of a line of known curvature [1/m], from the origin ahead."""
    heading = np.concatenate([[0.0], np.cumsum(0.5 * (curvature[1:] + curvature[:-1]) * step)])
    middle = 0.5 * (heading[1:] + heading[:-1])
    forward = np.concatenate([[0.0], np.cumsum(np.cos(middle) * step)])
    left = np.concatenate([[0.0], np.cumsum(np.sin(middle) * step)])
    return forward, left, heading


def test_a_circuits_joints_keep_the_heading_and_its_laps_repeat():
    square = Circuit(sections=(Straight(30.0), Bend(8.0, math.pi / 2)) * 4, transition=5.0, time=100.0, wait=0.0)
    curvature, _ = square.lap
    assert np.sum(curvature) * square.length / len(curvature) == pytest.approx(2.0 * math.pi, rel=1e-5)
    assert curvature.max() == pytest.approx(1.0 / 8.0)
    assert np.max(np.abs(np.diff(curvature))) < 1.01 * STEP / 5.0 / 8.0
    count = len(curvature)
    assert np.array_equal(square.way.curvature[:count], square.way.curvature[count : 2 * count])
    assert square.plan.distance[round(100.0 / TICK) - 1] < square.way.distance[-1]


@pytest.mark.parametrize("seed", range(1))
@pytest.mark.parametrize("road", [City(), Country(), Motorway()])
def test_a_natural_drive_keeps_its_limits(seed, road):
    course = NaturalDrive(roads=(road,), time=300.0, seed=seed, wait=2.0)
    plan, way = course.plan, course.way
    lateral = plan.speed**2 * np.abs(np.interp(plan.distance, way.distance, way.curvature))
    assert len(plan.speed) * TICK > 300.0
    assert lateral.max() < 1.1 * road.lateral_acceleration
    assert plan.speed.max() <= road.speed[1] + 1e-6
    assert plan.acceleration.max() < 1.5 * 1.001
    assert plan.acceleration.min() > -2.0 * 1.001
    assert np.max(np.abs(way.slopes["road.bank_angle"])) <= road.greatest_bank + 1e-9
    assert np.max(np.abs(way.slopes["road.grade_angle"])) < 5.0 * road.grade
    assert np.max(np.abs(np.diff(way.curvature))) < 0.2 * np.max(np.abs(way.curvature))


def test_the_circle_of_iso_4138_has_its_radius():
    course = load("iso-4138-constant-radius")
    forward, left, _ = drawn(course.way.curvature, STEP)
    place = course.way.distance > 70.0
    around = np.column_stack([forward[place], left[place], np.ones(np.sum(place))])
    # Circle through points: x^2 + y^2 = 2 a x + 2 b y + c.
    (a, b, c), *_ = np.linalg.lstsq(around * [2.0, 2.0, 1.0], forward[place] ** 2 + left[place] ** 2, rcond=None)
    assert math.sqrt(c + a * a + b * b) == pytest.approx(100.0, rel=1e-4)
    assert course.plan.speed[-1] == pytest.approx(25.0)
    assert np.allclose(np.gradient(course.plan.distance, TICK)[5:-5], course.plan.speed[5:-5], atol=0.01)


def test_the_double_lane_change_is_where_the_standard_puts_it():
    course = DoubleLaneChange()
    forward, left, heading = drawn(course.way.curvature, STEP)
    entry = course.approach
    assert abs(np.interp(entry, forward, left)) < 0.01
    aside = entry + 15.0 + 30.0 + 12.5
    assert np.interp(aside, forward, left) == pytest.approx(3.5, abs=0.03)
    assert np.interp(entry + 125.0, forward, left) == pytest.approx(0.0, abs=0.05)
    assert abs(heading[-1]) < 0.01
    lanes = ((0.0, 15.0, 0.0), (45.0, 70.0, 3.5), (95.0, 125.0, 0.0))
    for first, last, middle in lanes:
        inside = (forward >= entry + first) & (forward <= entry + last)
        assert np.max(np.abs(left[inside] - middle)) < 0.65, "room for a car of 1.8 m"


def level_way(speed=20.0, length=600.0, curvature=None, lateral=3.0, **more):
    count = int(length / 0.5) + 1
    curvature = np.zeros(count) if curvature is None else curvature
    return Way(curvature, np.full(count, speed), np.full(count, lateral), **more)


def test_a_halt_in_the_middle_lasts_as_long_as_it_should():
    plan = Pace(smoothing=0.6).plan(level_way(stops=((300.0, 7.0),)))
    still = plan.speed < 1e-6
    assert np.sum(still) * TICK == pytest.approx(7.0 - 0.6, abs=0.1)
    assert np.allclose(plan.distance[still], 300.0, atol=0.05)
    # 20 m/s; 100 m of braking at 2, 133 m of acceleration at 1.5.
    braking, speeding = 20.0**2 / 4.0, 20.0**2 / 3.0
    moving = (600.0 - braking - speeding) / 20.0 + 10.0 + 20.0 / 1.5
    assert len(plan.speed) * TICK == pytest.approx(moving + 7.0, abs=0.05)


def test_a_plan_keeps_its_limits():
    place = np.arange(0.0, 600.5, 0.5)
    bent = 0.02 * np.exp(-(((place - 300.0) / 40.0) ** 2))
    pace = Pace(acceleration=1.2, braking=2.5, smoothing=0.6)
    plan = pace.plan(level_way(curvature=bent, stops=((0.0, 2.0), (500.0, 2.0))))
    lateral = plan.speed**2 * np.interp(plan.distance, place, bent)
    assert lateral.max() < 3.0 * 1.03, "smoothing over time lets through a little"
    assert plan.acceleration.max() < 1.2 * 1.001
    assert plan.acceleration.min() > -2.5 * 1.001
    assert np.max(np.abs(np.diff(plan.acceleration[:-50]))) < (1.2 + 2.5) * TICK / 0.6 * 1.1, "no jerks"
    assert np.all(plan.speed > -1e-9)


HALF_LANE = 0.5 * (3.5 - 1.8)
"""Room on either side of a car of 1.8 m in a lane of 3.5 m [m]."""


def driven(course, seconds=None):
    outcome = run(EpsCar(), course, seconds)
    assert outcome.diverged_at is None
    return {name: channel.values for name, channel in outcome.recording.channels.items()}


@pytest.mark.parametrize("name", ["short-round"])
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
