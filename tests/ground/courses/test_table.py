import math

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod_lab.ground.courses import load
from tierod_lab.ground.courses.catalogue import read_table
from tierod_lab.ground.courses.way import STEP


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


def test_a_table_that_asks_for_attention(tmp_path):
    course = load(written(tmp_path, "time,speed,attention\n0,5,1\n10,5,0.5\n"))
    columns = course.columns(np.array([5.0]), np.zeros(1), 0.0, 0.0)
    assert columns["demand.attention"] == pytest.approx([0.75])


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
        ("time,time\n0,1\n1,1\n", "'time' is there twice"),
        ("# remark\ntime,speed\n0,1\n1,a\n", "line 4: could not convert"),
        ("time,speed\n0,1\n1\n", "line 3: 1 values, but there are 2 columns"),
        ("time,speed\n0,1\n1,nan\n", "line 3: a value is not finite"),
        ("time,speed\n0,1\n5,1\n3,1\n", "line 4: the time does not grow"),
        ("time,speed\n0,1\n", "at least two rows"),
        ("speed,grip\n0,1\n1,1\n", "there is no column distance or x"),
        ("distance,speed\n0,1\n1,1\n", "there is no column curvature"),
        ("x,speed\n0,1\n1,1\n", "there is no column y"),
        ("distance,curvature\n0,0\n0.3,0.1\n", "the way is 0.3 m long; give at least 1 m"),
        ("x,y\n0,0\n5,0\n5,0\n9,0\n", "two points in a row are the same"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(ParameterError) as caught:
        load(path).duration  # noqa: B018
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_before_the_first_row_and_after_the_last_one_the_speed_stays(tmp_path):
    speed, rise = load(written(tmp_path, "time,speed\n5,3\n10,13\n")).speed_at(
        np.array([0.0, 4.9, 5.1, 9.9, 10.0, 20.0])
    )
    assert speed == pytest.approx([3.0, 3.0, 3.2, 12.8, 13.0, 13.0])
    assert rise == pytest.approx([0.0, 0.0, 2.0, 2.0, 0.0, 0.0])


def test_a_missing_table(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        read_table(tmp_path / "none.csv")
