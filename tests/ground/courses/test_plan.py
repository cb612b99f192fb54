import numpy as np
import pytest

from tierod_lab.ground.courses.base import WayCourse
from tierod_lab.ground.courses.course import Grid
from tierod_lab.ground.courses.way import TICK, Pace, Way, reachable


def way(speed=20.0, length=600.0, curvature=None, lateral=3.0, **more):
    count = int(length / 0.5) + 1
    curvature = np.zeros(count) if curvature is None else curvature
    return Way(curvature, np.full(count, speed), np.full(count, lateral), **more)


def test_from_rest_the_plan_is_that_of_constant_acceleration():
    plan = Pace(acceleration=2.0, braking=2.0, smoothing=0.0).plan(way(stops=((0.0, 3.0),)))
    time = np.arange(len(plan.speed)) * TICK
    first = time < 13.0 - 2 * TICK
    assert np.allclose(plan.speed[first], 2.0 * np.maximum(time[first] - 3.0, 0.0), atol=0.05)
    assert np.allclose(plan.distance[first], np.maximum(time[first] - 3.0, 0.0) ** 2, atol=0.05)


def test_a_halt_in_the_middle_lasts_as_long_as_it_should():
    plan = Pace(smoothing=0.6).plan(way(stops=((300.0, 7.0),)))
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
    plan = pace.plan(way(curvature=bent, stops=((0.0, 2.0), (500.0, 2.0))))
    lateral = plan.speed**2 * np.interp(plan.distance, place, bent)
    assert lateral.max() < 3.0 * 1.03, "smoothing over time lets through a little"
    assert plan.acceleration.max() < 1.2 * 1.001
    assert plan.acceleration.min() > -2.5 * 1.001
    assert np.max(np.abs(np.diff(plan.acceleration[:-50]))) < (1.2 + 2.5) * TICK / 0.6 * 1.1, "no jerks"
    assert np.all(plan.speed > -1e-9)


def test_speed_is_the_derivative_of_distance():
    plan = Pace().plan(way(stops=((0.0, 2.0), (250.0, 4.0))))
    assert np.allclose(np.cumsum(plan.speed) * TICK, plan.distance - plan.distance[0], atol=0.3)


def test_the_greatest_reachable_speed_touches_every_limit():
    limit = np.array([30.0, 30.0, 5.0, 30.0, 30.0, 30.0])
    speed = reachable(limit, 10.0, 2.0, 3.0)
    assert speed**2 == pytest.approx([25.0 + 120.0, 25.0 + 60.0, 25.0, 65.0, 105.0, 145.0])


class Road(WayCourse):
    @property
    def way(self):
        return way(stops=((0.0, 2.0), (300.0, 5.0)))


def at(course, time, distance):
    columns = course.columns(np.array([time]), np.array([distance]), 10.0, 0.3)
    return {name: float(values[0]) for name, values in columns.items()}


def test_a_car_on_its_plan_is_asked_for_the_plan():
    course = Road()
    for tick in (200, 700, 1000, 1500):
        planned = course.plan.speed[tick]
        assert at(course, tick * TICK, course.plan.distance[tick])["demand.speed"] == pytest.approx(planned, abs=1e-9)


def test_a_late_car_hurries_but_not_beyond_what_the_way_allows():
    course, tick = Road(), 700
    place, speed = course.plan.distance[tick], course.plan.speed[tick]
    assert at(course, tick * TICK, place - 2.9)["demand.speed"] == pytest.approx(speed)
    assert at(course, tick * TICK, place - 5.0)["demand.speed"] == pytest.approx(speed + 0.4)
    assert at(course, tick * TICK, place - 100.0)["demand.speed"] == pytest.approx(1.05 * 20.0)
    assert at(course, tick * TICK, place + 5.0)["demand.speed"] == pytest.approx(speed - 0.4)
    assert at(course, tick * TICK, place + 300.0)["demand.speed"] == 0.0


def test_a_halt_is_a_halt_for_a_car_that_is_about_there():
    course = Road()
    tick = int(np.argmax((course.plan.distance > 299.99) & (course.plan.speed < 1e-6))) + 50
    assert at(course, tick * TICK, 298.0)["demand.speed"] == pytest.approx(0.0, abs=1e-6)


def test_a_grid_is_straight_between_its_points_and_constant_beyond():
    grid = Grid(0.5, {"a": np.array([0.0, 1.0, 4.0]), "b": np.array([1.0, 1.0, 0.0])})
    places = np.array([-3.0, 0.0, 0.25, 0.5, 0.75, 1.0, 9.0])
    read = grid.at(places)
    assert np.allclose(read["a"], np.interp(places, [0.0, 0.5, 1.0], [0.0, 1.0, 4.0]))
    assert np.allclose(read["b"], np.interp(places, [0.0, 0.5, 1.0], [1.0, 1.0, 0.0]))
