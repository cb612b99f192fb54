import math
import pickle

import numpy as np
import pytest

from tierod.core.block import leaves, skeleton
from tierod.core.errors import ParameterError
from tierod.core.toml import kind_name, override
from tierod.core.toml_document import Document
from tierod_lab.ground.cars.column_bench import Acting
from tierod_lab.ground.courses import described, load, shipped
from tierod_lab.ground.courses.catalogue import AnyCourse
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
def test_a_shipped_course_is_described_in_one_sentence(name):
    text = described(name)
    assert text[0].isupper()
    assert text.endswith(".")
    assert 20 < len(text) < 130
    assert COURSES[name].name == name


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_course_says_only_what_a_car_knows_in_finite_numbers(name):
    course = COURSES[name]
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


def test_a_scenario_can_change_any_parameter():
    course = override(load("city"), {"seed": 4, "time": "5 min", "roads.0.halts": 0.5, "pace.braking": 3.0})
    assert (course.seed, course.time, course.roads[0].halts, course.pace.braking) == (4, 300.0, 0.5, 3.0)
    assert override(load("slalom"), {"speed": "54 km/h"}).speed == pytest.approx(15.0)


def test_a_file_of_ones_own(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('kind = "step-steer"\nspeed = "36 km/h"\nangle = "90 deg"\n')
    course = load(path)
    assert (course.name, course.speed, course.angle) == ("mine", 10.0, pytest.approx(math.pi / 2))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('kind = "step-stear"', "line 1: no kind is called 'step-stear'; did you mean 'step-steer'"),
        ('kind = "slalom"\nspede = 3.0', "line 2: 'spede' is not known here; did you mean 'speed'"),
        ('kind = "slalom"\nspeed = -3.0', "line 2: 'speed' is -3 m/s, but has to be above 0 m/s"),
        ('kind = "slalom"\nspeed = "3 kg"', "line 2: 'speed' is '3 kg'"),
        ('kind = "circuit"', "a circuit needs sections"),
        ('kind = "natural-drive"\nroads = []', "at least one kind of road"),
        ('kind = "natural-drive"\nroads = [{ kind = "city", speed = [9.0, 3.0] }]', "give the lower value first"),
        ('kind = "random-steer"\nlowest = 3.0\nhighest = 1.0', "give the lower one first"),
        ('kind = "time-table"', "needs its CSV file"),
        (
            'kind = "slalom"\n[[conditions]]\nkind = "grip"\nwindow = { kind = "during", start = 5.0, end = 3.0 }',
            "a window from 5 to 3 s is empty",
        ),
    ],
)
def test_mistakes_are_named(tmp_path, text, said):
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(ParameterError) as caught:
        load(path).duration  # noqa: B018
    assert said in str(caught.value)


def test_an_unknown_name_shows_the_nearest():
    with pytest.raises(ParameterError, match="did you mean 'slalom'"):
        load("slalon")


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        load(tmp_path / "none.toml")


def test_a_course_from_the_text_of_a_document():
    from tierod_lab.ground.courses import from_document

    assert from_document(Document.parse('kind = "slalom"\nname = "short"\ncones = 4')).cones == 4
