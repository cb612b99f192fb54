"""Campaign files as a whole: what they become, and what is refused before anything is driven."""

import dataclasses
from pathlib import Path

import pytest

from tierod.core.errors import ParameterError
from tierod.core.toml_document import Document
from tierod_lab.campaign.campaign import from_document, load, shipped

BASE = """name = "country"
description = "A country road."
car = "midsize-eps-light"
course = "country"
seconds = 20.0
"""
FILE = """name = "steps"
description = "Steps of friction."
scenario = "base.toml"
seeds = [1, 2]
same_car = ["seed"]

[changes]
seconds = 30.0

[axes.friction]
set = "car.parameters.steering.friction.level"
values = [3.0, "4 N*m"]

[faults.step]
element = "steering.friction.level"
behaviour = "step"
start = "10 s"
sizes = [6.0, 8.0]

[[monitors]]
monitor = "friction"
vehicle = "midsize-eps"
baseline = "first fault-free drive"

[[gates]]
figure = "missed_share"
goal = "<= 0.1"
where = { size = 8.0 }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "base.toml").write_text(BASE)
    return tmp_path


def campaign(folder, text=FILE):
    return from_document(Document.parse(text, folder / "c.toml", "campaign"))


def refusal(folder, text):
    with pytest.raises(ParameterError) as refused:
        campaign(folder, text)
    return str(refused.value).removeprefix(f"{folder / 'c.toml'}, ")


def test_every_point_becomes_a_scenario_with_its_changes_faults_and_seed(folder):
    made = campaign(folder)
    assert made.axes == {
        "friction": ["3", "4 N*m"], "fault": ["fault-free", "step"], "size": ["", "6", "8"], "seed": ["1", "2"],
    }  # fmt: skip
    assert made.hours == pytest.approx(12 * 30.0 / 3600.0)
    cells = {tuple(cell.point.place.values()): cell for cell in made.plan.cells}
    cell = cells["4 N*m", "step", "6", "2"]
    assert (cell.scenario.seed, cell.scenario.duration) == (2, 30.0)
    assert cell.scenario.car.steering.friction.level == 4.0
    assert [fault.name for fault in cell.scenario.faults] == ["step"]
    assert cells["3", "fault-free", "", "1"].scenario.car.steering.friction.level == 3.0
    assert len({cell.key for cell in made.plan.cells}) == 12


def test_keys_know_all_that_decides(folder):
    one = campaign(folder)
    other = campaign(folder, FILE.replace("8.0", "9.0"))
    same = {cell.key for cell in one.plan.cells} & {cell.key for cell in other.plan.cells}
    assert len(same) == 8
    settling = dataclasses.replace(one.plan, settling=20.0)
    cell = one.plan.cells[0]
    judge = one.plan.judges[0]
    assert one.plan.verdict_key(cell, judge) != settling.verdict_key(cell, judge)
    believing = dataclasses.replace(judge, belief=dataclasses.replace(judge.belief, parameters={}))
    assert one.plan.verdict_key(cell, judge) != one.plan.verdict_key(cell, believing)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ('"base.toml"', '"bse.toml"', 3, "there is no scenario file"),
        ("seconds = 30.0", 'secnds = "1 s"', 8, "'secnds' is not known here; did you mean 'seconds'"),
        ('"4 N*m"]', '"4 m"]', 12, "friction '4 m': "),
        ('"friction"\nvehicle', '"fricton"\nvehicle', 21, "no monitor 'fricton'; did you mean 'friction'?"),
        ('vehicle = "midsize-eps"', 'vehicle = "midsize-eps"\nvariant = "refind"', 23, "did you mean 'refined'"),
        ('same_car = ["seed"]', 'same_car = ["sed"]', 5, "'sed' is not an axis of cars; did you mean 'seed'?"),
        (
            'same_car = ["seed"]',
            'same_car = ["seed"]\nexclude = [{ fault = "fault-free", seed = 2 }]',
            5,
            "no fault-free drive of the same car (seed 2)",
        ),
        ('same_car = ["seed"]\n', "", None, "'same_car' is missing"),
        ('"missed_share"', '"missed_shar"', 26, "no figure is called 'missed_shar'; did you mean 'missed_share'"),
        ('"<= 0.1"', '"< 0.1"', 27, "'< 0.1' is not a goal"),
        (
            "{ size = 8.0 }",
            '{}\n[[monitors]]\nmonitor = "friction"\nvehicle = "midsize-eps"\nbaseline = "none"',
            29,
            "two monitors are called 'friction, pre-sliding'",
        ),
        ("{ size = 8.0 }", '{ size = 8.0, fault = "fault-free" }', 28, "no cell of the matrix is there"),
    ],
)
def test_slips_and_contradictions_are_refused_with_their_line(folder, old, new, line, message):
    assert old in FILE
    refused = refusal(folder, FILE.replace(old, new, 1))
    assert message in refused
    if line is not None:
        assert refused.startswith(f"line {line}: ")


@pytest.mark.parametrize("name", shipped())
def test_shipped_campaigns_fit_together(name):
    made = load(name)
    assert made.gates
    assert len(made.file.description.split()) > 4
    assert made.file.description[-1] in ".?"


@pytest.mark.slow
def test_the_file_of_the_documentation_is_a_campaign(tmp_path):
    page = Path(__file__).parents[2] / "docs" / "how-to" / "campaigns.md"
    text = page.read_text(encoding="utf-8").partition("```toml\n")[2].partition("```")[0]
    made = from_document(Document.parse(text, tmp_path / "c.toml"))
    places = [cell.point.place for cell in made.plan.cells]
    assert list(places[0]) == ["car", "route", "tyres", "fault", "size", "seed"]
    # Two cars, routes, tyres; five seeds: fault-free, three sizes, the lost signal of one car; twenty more fault-free.
    assert len(places) == 8 * 5 * 4 + 4 * 5 + 8 * 20
    assert len({cell.key for cell in made.plan.cells}) == len(places)
