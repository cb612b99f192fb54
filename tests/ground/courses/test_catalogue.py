import math
import pickle

import numpy as np
import pytest

from tierod.core.block import leaves, skeleton
from tierod.core.errors import ParameterError
from tierod.core.toml import kind_name
from tierod_lab.ground.cars.benches import Acting
from tierod_lab.ground.courses import AnyCourse, load, shipped
from tierod_lab.ground.courses.way import STEP
from tierod_lab.ground.parts import Demand, Road, Wind

KNOWN = {
    f"{part}.{path}"
    for part, kind in (("road", Road), ("wind", Wind), ("demand", Demand))
    for path, _ in leaves(skeleton(kind))
} | {path for path, _ in leaves(skeleton(Acting)) if not path.startswith("ports.")}
COURSES = {name: load(name) for name in shipped()}


def test_every_kind_of_course_that_needs_no_file_of_ones_own_is_shipped():
    kinds = {kind_name(type(course)) for course in COURSES.values()}
    assert {kind_name(kind) for kind in AnyCourse.__args__} - kinds == {"way-table"}


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_course_says_only_what_a_car_knows_in_finite_numbers(name):
    course = COURSES[name]
    assert 20 < len(course.description) < 130
    assert course.description.endswith(".")
    assert 5.0 < course.duration < 800.0
    for first in (0.0, 0.3 * course.duration, course.duration, course.duration + 100.0):
        time = first + 1e-3 * np.arange(200)
        columns = course.columns(time, 8.0 * time, 8.0, 0.25)
        assert set(columns) <= KNOWN
        assert all(np.shape(values) == (200,) and np.isfinite(values).all() for values in columns.values())
    assert math.isfinite(course.start.speed)


@pytest.mark.parametrize("name", shipped())
def test_pieces_do_not_change_what_is_asked(name):
    course = COURSES[name]
    time = 10.0 + 1e-3 * np.arange(400)
    whole = course.columns(time, 7.0 * time, 7.0, 0.2)
    parts = [course.columns(time[part], 7.0 * time[part], 7.0, 0.2) for part in (slice(0, 130), slice(130, 400))]
    for key, values in whole.items():
        usual = 1.0 if key.startswith(("road.adhesion", "demand.grip")) else 0.0
        pairs = zip(parts, (130, 270), strict=True)
        joined = np.concatenate([each.get(key, np.full(size, usual)) for each, size in pairs])
        assert np.array_equal(values, joined)


@pytest.mark.parametrize("name", shipped())
def test_a_used_course_can_be_sent_to_a_worker(name):
    time = 1e-3 * np.arange(50)
    course = COURSES[name]
    before = course.columns(time, time, 1.0, 0.0)
    after = pickle.loads(pickle.dumps(course)).columns(time, time, 1.0, 0.0)
    assert all(np.array_equal(values, after[key]) for key, values in before.items())


def written(folder, text, name="course.csv"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_table_over_time(tmp_path):
    path = written(
        tmp_path,
        "# Two rows of remarks\n# about it.\ntime,speed [km/h],steering_wheel_angle [deg],grip,crosswind_speed\n"
        "0,36,0,1,0\n2,36,90,1,4\n4,72,90,0,4\n",
    )
    course = load(path)
    columns = course.columns(np.array([0.0, 1.0, 3.0, 9.0]), np.zeros(4), 0.0, 0.0)
    assert columns["demand.speed"] == pytest.approx([10.0, 10.0, 15.0, 20.0])
    assert columns["demand.acceleration"] == pytest.approx([0.0, 0.0, 5.0, 0.0])
    assert columns["demand.steering_wheel_angle"] == pytest.approx([0.0, math.pi / 4, math.pi / 2, math.pi / 2])
    assert columns["demand.grip"] == pytest.approx([1.0, 1.0, 0.5, 0.0])
    assert columns["wind.crosswind_speed"] == pytest.approx([0.0, 2.0, 4.0, 4.0])
    assert list(columns["demand.attention"]) == [0.0] * 4
    assert (course.duration, course.start.speed) == (4.0, pytest.approx(10.0))
    assert course.description == "Two rows of remarks about it."


def test_a_table_of_curvature(tmp_path):
    path = written(tmp_path, "distance,curvature,speed,bank_angle [deg]\n0,0,8,0\n100,0.05,8,0\n200,0.05,8,2\n")
    course = load(path)
    columns = course.columns(np.zeros(3), np.array([0.0, 50.0, 150.0]), 0.0, 0.0)
    assert columns["road.curvature"] == pytest.approx([0.0, 0.025, 0.05])
    assert columns["road.bank_angle"] == pytest.approx([0.0, 0.0, math.radians(1.0)])
    assert course.plan.speed[0] == pytest.approx(8.0)
    assert course.plan.speed[-1] == pytest.approx(math.sqrt(3.0 / 0.05), rel=1e-3)


def test_points_round_a_circle_make_its_curvature(tmp_path):
    angle = np.linspace(0.0, 2.0 * math.pi, 25)
    rows = "".join(f"{40.0 * math.sin(a):.6f},{40.0 * (1.0 - math.cos(a)):.6f}\n" for a in angle)
    toml = tmp_path / "circle.toml"
    written(tmp_path, f"x,y\n{rows}", "points.csv")
    toml.write_text('kind = "way-table"\nfile = "points.csv"\nlaps = 2\nspeed = 8.0\n')
    course = load(toml)
    assert course.way.curvature == pytest.approx(np.full(len(course.way.curvature), 1.0 / 40.0), rel=1e-2)
    assert len(course.way.curvature) * STEP == pytest.approx(2 * 2.0 * math.pi * 40.0, abs=1.5)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,sped\n0,1\n1,1\n", "line 1: no column is called 'sped'; did you mean 'speed'"),
        ("time,speed [kg]\n0,1\n1,1\n", "line 1: column 'speed': "),
        ("# remark\ntime,speed\n0,1\n1,a\n", "line 4: could not convert"),
        ("time,speed\n0,1\n5,1\n3,1\n", "line 4: the time does not grow"),
        ("speed,grip\n0,1\n1,1\n", "there is no column distance or x"),
        ("distance,curvature\n0,0\n0.3,0.1\n", "the way is 0.3 m long; give at least 1 m"),
        ("x,y\n0,0\n5,0\n5,0\n9,0\n", "two points in a row are the same"),
    ],
)
def test_mistakes_in_a_table(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(ParameterError) as caught:
        load(path).duration  # noqa: B018
    assert said in str(caught.value)
    assert str(path) in str(caught.value)
