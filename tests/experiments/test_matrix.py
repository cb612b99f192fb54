"""The matrix: every combination, less what is excluded, and what is included; slips named with their line."""

import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml import build
from tierod.core.toml_document import Document
from tierod_lab.campaign.matrix import CampaignFile, Matrix

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
    return Matrix(build(CampaignFile, document.content, document), document).points()


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


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (HEAD + "[axes.seed]\nvalues = [1]\n", 5, "an axis cannot be called 'seed'"),
        (HEAD + "[axes.mass]\nvalues = [1,\n 1]\n", 7, "two levels '1'"),
        (HEAD + "[faults.fault-free]\nelement = 'yaw_rate'\n", 5, "cannot be called 'fault-free'"),
        (HEAD + "[faults.step]\nelement = 'yaw_rate'\nbehaviour = 'ofset'\n", 7, "did you mean 'offset' or 'noise'?"),
        (HEAD + "fault_free = false\n", 5, "the matrix is empty"),
        (HEAD + "exclude = [{ faul = 'fault-free' }]\n", 5, "no axis is called 'faul'; did you mean 'fault'?"),
        (HEAD + "include = [\n{ fault = 'fault-fre' }]\n", 6, "no level 'fault-fre'; did you mean 'fault-free'?"),
        (HEAD + "exclude = [{ seed = 7 }, { seed = 7 }]\n", 5, "this excludes no cell that is left"),
        (HEAD.replace("{ first = 7, count = 2 }", "[1, 1]"), 4, "seeds are whole numbers"),
        (HEAD.replace("count = 2", "count = 1000000000000"), 4, "give at most 1000000"),
    ],
)
def test_slips_are_named_with_their_line(text, line, message):
    with pytest.raises(ParameterError) as refused:
        matrix(text + MONITORS)
    assert str(refused.value).startswith(f"c.toml, line {line}: ")
    assert message in str(refused.value)
