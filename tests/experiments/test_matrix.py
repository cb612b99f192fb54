"""The matrix: every combination, less what is excluded, and what is included; slips named with their line."""

import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod_lab.campaign.matrix import CampaignFile, points, with_changes
from tierod_lab.ground.faults.fault import AtTime

HEAD = """name = "steps"
description = "Steps of friction."
scenario = "base"
seeds = { first = 7, count = 2 }
"""
MONITORS = """
[[monitors]]
monitor = "friction"
vehicle = "midsize-eps"
baseline = "none"
"""
AXES = """
[axes.car]
values = ["small", "large"]
[axes.tyre.levels]
summer = {}
winter = { "parameters.chassis.stiffness" = 0.8 }
[faults.step]
element = "steering.friction.level"
behaviour = "step"
start = "30 s"
sizes = [1.5, "4 N*m"]
"""


def matrix(text):
    document = Document.parse(text, "c.toml", "campaign")
    return points(build(CampaignFile, document.content, document), document)


def places(text):
    return [" ".join(filter(None, point.place.values())) for point in matrix(text)]


def test_the_product_of_all_axes_with_faults_and_seeds_innermost():
    found = matrix(HEAD + AXES + MONITORS)
    assert len(found) == 2 * 2 * 3 * 2
    assert list(found[0].place) == ["car", "tyre", "fault", "size", "seed"]
    assert [" ".join(p.place.values()) for p in found[:4]] == [
        "small summer fault-free  7", "small summer fault-free  8",
        "small summer step 1.5 7", "small summer step 1.5 8",
    ]  # fmt: skip
    assert [point.seed for point in found[:2]] == [7, 8]


def test_levels_change_the_scenario():
    last = matrix(HEAD + AXES + MONITORS)[-1]
    assert last.changes({"duration": 60, "car": "other"}) == {
        "duration": 60,
        "car": "large",
        "parameters.chassis.stiffness": 0.8,
    }


def test_faults_come_with_their_sizes_and_with_what_acts_together():
    point = matrix(HEAD + AXES + MONITORS)[2]
    (fault,) = point.faults
    assert (fault.name, fault.element, fault.trigger) == ("step", "steering.friction.level", AtTime(30.0))
    assert fault.behaviour.to == 1.5
    together = HEAD + """
[faults.double]
element = "yaw_rate"
behaviour = "offset"
size = "1 deg/s"
together = [{ element = "driver_torque", behaviour = "total-loss" }]
""" + MONITORS  # fmt: skip
    assert [fault.element for fault in matrix(together)[-1].faults] == ["yaw_rate", "driver_torque"]


def test_an_axis_sets_what_it_is_asked_to():
    text = HEAD + '[axes.mass]\nset = "parameters.chassis.mass"\nvalues = [1500.0, 1600.5]\n' + MONITORS
    assert places(text) == ["1500 fault-free 7", "1500 fault-free 8", "1600.5 fault-free 7", "1600.5 fault-free 8"]
    assert matrix(text)[0].changes({}) == {"parameters.chassis.mass": 1500.0}


def test_cells_are_excluded_and_included():
    text = HEAD.replace("seeds = { first = 7, count = 2 }", "seeds = [1]") + """
exclude = [{ car = "large", tyre = "winter" }, { fault = "step", size = ["1.5"], tyre = "winter" }]
include = [{ fault = "fault-free", car = "small", tyre = "summer", seeds = { first = 1, count = 3 } }]
""" + AXES + MONITORS  # fmt: skip
    assert places(text) == [
        "small summer fault-free 1", "small summer step 1.5 1", "small summer step 4 N*m 1",
        "small winter fault-free 1", "small winter step 4 N*m 1",
        "large summer fault-free 1", "large summer step 1.5 1", "large summer step 4 N*m 1",
        "small summer fault-free 2", "small summer fault-free 3",
    ]  # fmt: skip


def test_without_faults_all_drives_are_fault_free():
    assert places(HEAD + MONITORS) == ["fault-free 7", "fault-free 8"]


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (HEAD + '[axes.seed]\nvalues = [1]\n', 5, "an axis cannot be called 'seed'"),
        (HEAD + "[axes.mass]\n", 5, "either values or levels"),
        (HEAD + "[axes.mass]\nvalues = [1]\nlevels = { a = {} }\n", 5, "either values or levels"),
        (HEAD + "[axes.mass]\nset = 'm'\nlevels = { a = {} }\n", 5, "'set' works with values"),
        (HEAD + "[axes.mass]\nvalues = [1,\n 1]\n", 7, "two levels '1'"),
        (HEAD + "[faults.fault-free]\nelement = 'yaw_rate'\n", 5, "cannot be called 'fault-free'"),
        (HEAD + "[faults.step]\nsizes = []\n", 5, "'sizes' is a list"),
        (HEAD + "[faults.step]\nsize = 1\nsizes = [1]\n", 6, "state the same"),
        (HEAD + "[faults.step]\nelement = 'yaw_rate'\nbehaviour = 'ofset'\n", 7, "did you mean 'offset' or 'noise'?"),
        (HEAD + "fault_free = false\n", 5, "the matrix is empty"),
        (HEAD + "exclude = [{ fault = 'fault-free' }]\n", 5, "every cell of the matrix is excluded"),
        (HEAD + "exclude = [{ faul = 'fault-free' }]\n", 5, "no axis is called 'faul'; did you mean 'fault'?"),
        (HEAD + "include = [\n{ fault = 'fault-fre' }]\n", 6, "no level 'fault-fre'; did you mean 'fault-free'?"),
        (HEAD + "exclude = [{ seed = 7 }, { seed = 7 }]\n", 5, "this excludes no cell that is left"),
        (HEAD.replace("{ first = 7, count = 2 }", "[1, 1]"), 4, "seeds are whole numbers"),
        (HEAD.replace("{ first = 7, count = 2 }", "[]"), 4, "seeds are whole numbers"),
        (HEAD.replace("count = 2", "count = 1000000000000"), 4, "give at most 1000000"),
        (HEAD + "include = [{ seeds = { first = 0, count = 3000000 } }]\n", 5, "give at most 1000000"),
        (HEAD.replace("count = 2", "count = 0"), 4, "has to be above 0"),
        (HEAD + "include = [{ seeds = [1.5] }]\n", 5, "seeds are whole numbers"),
        (HEAD + "exlude = []\n", 5, "'exlude' is not known here; did you mean 'exclude' or"),
    ],
)  # fmt: skip
def test_slips_are_named_with_their_line(text, line, message):
    with pytest.raises(ParameterError) as refused:
        matrix(text + MONITORS)
    assert str(refused.value).startswith(f"c.toml, line {line}: ")
    assert message in str(refused.value)


def test_values_are_set_at_dotted_names_however_the_tables_are_written():
    assert with_changes({}, {"a.b.c": 1}) == {"a": {"b": {"c": 1}}}
    assert with_changes({"a": {"b.c": 1, "d": 2}}, {"a.b.c": 3}) == {"a": {"b.c": 3, "d": 2}}
    assert with_changes({"a": {"b": {"c": 1}}}, {"a.b.d": 2, "a.e": 3}) == {"a": {"b": {"c": 1, "d": 2}, "e": 3}}
    assert with_changes({"a": "text"}, {"a.b": 1}) == {"a": {"name": "text", "b": 1}}
    assert with_changes({"a": 5}, {"a.b": 1}) == {"a": {"b": 1}}
    assert with_changes({}, {"car.mass": 1, "car": "small"}) == {"car": {"name": "small", "mass": 1}}
    before = {"a": {"b": 1}}
    with_changes(before, {"a.b": 2})
    assert before == {"a": {"b": 1}}
