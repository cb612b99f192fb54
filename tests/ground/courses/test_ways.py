"""Geometry of circuits, natural roads and lanes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses import load
from tierod_lab.ground.courses.circuit import Bend, Circuit, Halt, Straight
from tierod_lab.ground.courses.lane import DoubleLaneChange, Slalom, SteadyCircle, StraightLane
from tierod_lab.ground.courses.natural import City, Country, Motorway, NaturalDrive, Roundabouts
from tierod_lab.ground.courses.way import STEP, TICK, Pace, bump

ROUNDS = ("short-round", "long-round", "third-round")


@pytest.mark.parametrize("name", ROUNDS)
def test_a_round_closes(name):
    course = load(name)
    curvature, _ = course.lap
    forward, left, heading = drawn(np.append(curvature, curvature[0]), course.length / len(curvature))
    assert math.hypot(forward[-1], left[-1]) < 0.1
    assert abs(heading[-1]) == pytest.approx(2.0 * math.pi, abs=1e-3)


@pytest.mark.parametrize("name", ROUNDS)
def test_a_round_does_not_cross_itself(name):
    course = load(name)
    curvature, _ = course.lap
    forward, left, _ = drawn(curvature, course.length / len(curvature))
    apart = np.hypot(forward[:, None] - forward, left[:, None] - left)
    count = len(curvature)
    along = np.abs(np.arange(count)[:, None] - np.arange(count))
    far = np.minimum(along, count - along) * course.length / count > 12.0
    assert apart[far].min() > 6.0


@pytest.mark.parametrize("name", ROUNDS)
def test_a_round_has_tight_and_fast_parts_and_is_driven_hard(name):
    course = load(name)
    plan = course.plan
    lateral = plan.speed**2 * np.interp(plan.distance, course.way.distance, course.way.curvature)
    assert np.max(np.abs(course.way.curvature)) > 1.0 / 7.5
    assert plan.speed.max() > 11.0
    assert np.percentile(plan.speed[plan.speed > 1.0], 10) < 7.0
    assert course.lateral_acceleration * 0.9 < np.max(np.abs(lateral)) < course.lateral_acceleration * 1.1
    assert plan.acceleration.min() == pytest.approx(-course.pace.braking, rel=0.01)


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


def test_a_sections_limit_holds_there():
    course = Circuit(sections=(Straight(50.0, speed=6.0), Straight(50.0), Bend(30.0, math.pi)) * 2, wait=0.0)
    slow = np.mod(course.plan.distance, course.length / 2) < 49.0
    assert course.plan.speed[slow].max() < 6.3
    assert course.plan.speed[~slow].max() > 8.0


def test_a_bumps_area_is_its_arc():
    for arc in (5.0, 40.0, 300.0):
        for ramps in (0.5, 1.0):
            assert np.sum(bump(arc, ramps, 0.05)) * 0.05 == pytest.approx(arc, rel=1e-2)
    assert bump(100.0, 0.5).max() == 1.0


@pytest.mark.parametrize("seed", range(3))
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


def test_the_same_seed_makes_the_same_drive_to_the_bit():
    one, same, other = (NaturalDrive(seed=seed, time=200.0) for seed in (5, 5, 6))
    assert np.array_equal(one.way.curvature, same.way.curvature)
    assert np.array_equal(one.plan.distance, same.plan.distance)
    assert one.way.stops == same.way.stops
    assert not np.array_equal(one.way.curvature[:100], other.way.curvature[:100])


def test_halts_do_not_move_a_bend():
    seldom, often = (NaturalDrive(roads=(City(halts=halts),), time=300.0) for halts in (0.0, 0.8))
    shared = len(often.way.curvature)
    assert 0.0 < shared < len(seldom.way.curvature)
    assert np.array_equal(seldom.way.curvature[:shared], often.way.curvature)
    assert len(seldom.way.stops) == 0
    assert len(often.way.stops) > 10
    places = np.array([place for place, _ in often.way.stops])
    assert np.all(np.diff(places) > 5.0)
    assert np.max(np.abs(np.interp(places - 1.0, often.way.distance, often.way.curvature))) == 0.0


def test_a_natural_drive_passes_all_its_roads_again_and_again():
    course = NaturalDrive(time=2000.0, cycle=780.0)
    assert [type(kind).__name__ for _, kind in course.stretches[:6]] == ["City", "Country", "Motorway"] * 2
    starts = [place for place, _ in course.stretches]
    assert starts == sorted(starts)
    assert course.duration == 2000.0


def test_both_directions_are_turned():
    curvature = NaturalDrive(time=780.0, seed=3).way.curvature
    assert 0.5 < np.sum(np.maximum(curvature, 0.0)) / np.sum(np.maximum(-curvature, 0.0)) < 2.0


def test_a_roundabout_goes_right_round_and_out():
    shape = Roundabouts().draw(np.random.default_rng(0), 0.0)
    turn = np.sum(shape) * STEP
    assert min(abs(turn), abs(turn - math.pi / 2)) < 0.1
    assert shape[len(shape) // 8] < 0.0
    assert shape[len(shape) // 2] > 1.0 / 20.5


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


def test_a_circle_to_the_right():
    assert SteadyCircle(radius=-50.0).way.curvature[-1] == pytest.approx(-0.02)


def test_the_slalom_passes_its_cones_on_alternate_sides():
    course = Slalom()
    forward, left, heading = drawn(course.way.curvature, STEP)
    cones = course.approach + course.spacing * np.arange(1, course.cones + 1)
    passed = np.interp(cones, forward, left)
    assert np.allclose(passed, course.swing * (-1.0) ** np.arange(course.cones), atol=0.05)
    assert abs(left[-1]) < 0.2
    assert abs(heading[-1]) < 0.01


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


def test_a_straight_lane_is_straight_and_long_enough():
    course = StraightLane(speed=30.0, time=20.0)
    assert not course.way.curvature.any()
    assert course.way.distance[-1] >= 600.0
    assert (course.start.speed, course.duration) == (pytest.approx(30.0), 20.0)


def test_the_driver_sees_the_curvature_ahead():
    course = load("short-round")
    distance = np.array([20.0, 40.0, 60.0])
    columns = course.columns(np.zeros(3), distance, 8.0, 0.5)
    later = course.columns(np.zeros(3), distance + 4.0, 8.0, 0.0)
    assert np.array_equal(columns["demand.curvature_ahead"], later["demand.curvature_ahead"])
    assert np.array_equal(later["demand.curvature_ahead"], later["road.curvature"])


def test_a_changed_course_is_worked_out_anew():
    course = load("city")
    assert not np.array_equal(course.way.curvature[:500], replace(course, seed=1).way.curvature[:500])


def test_a_circuit_halts_in_every_lap_for_as_long_as_it_says():
    sections = (Straight(30.0), Bend(8.0, math.pi / 2)) * 4
    halts, pace = (Halt(15.0, 4.0), Halt(100.0, 2.0)), Pace(smoothing=0.0)
    course = Circuit(sections=sections, time=100.0, wait=0.0, halts=halts, pace=pace)
    standing = course.plan.speed < 1e-6
    places = np.mod(course.plan.distance[standing], course.length)
    assert np.all(np.minimum(np.abs(places - 15.0), np.abs(places - 100.0)) < STEP)
    first = standing & (course.plan.distance < course.length) & (np.arange(len(standing)) * TICK > 1.0)
    assert np.sum(first) * TICK == pytest.approx(6.0, abs=0.1)
    with pytest.raises(ParameterError, match="one after the other"):
        Circuit(sections=sections, halts=(Halt(50.0), Halt(20.0)))
