"""What the guide of the virtual test vehicle shows can be driven."""

import re
from pathlib import Path

import pytest

from tierod.core.toml import Document
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.scenarios import from_document

GUIDE = (Path(__file__).parents[3] / "docs" / "how-to" / "simulate.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(toml|text)\n(.*?)```", GUIDE, re.DOTALL)


def block(words):
    return next(text for _, text in BLOCKS if words in text)


def test_the_scenario():
    scenario = from_document(Document.parse(block("country-road-after-rain"), "guide.toml"))
    assert (scenario.duration, scenario.course.seed, scenario.car.chassis.mass) == (600.0, 8, 1750.0)
    assert scenario.with_run(seconds=1.0).run().diverged_at is None


def test_the_car(tmp_path):
    path = tmp_path / "my-car.toml"
    path.write_text(block("my-car"), encoding="utf-8")
    car = catalogue.load(path)
    assert car.block.steering.friction.level == 3.2
    assert car.source_of("chassis.mass") == "scales"


BEGIN = 'name = "x"\ndescription = "X."\ncar = "midsize-eps-light"\n'


def test_the_circuit():
    scenario = from_document(Document.parse(BEGIN + block("A small round"), "guide.toml"))
    assert scenario.duration == 180.0
    assert scenario.with_run(seconds=1.0).run().diverged_at is None


def test_the_table(tmp_path):
    (tmp_path / "ice.csv").write_text(block("adhesion_right"), encoding="utf-8")
    scenario = from_document(Document.parse(BEGIN + 'course = "ice.csv"', tmp_path / "guide.toml"))
    driven = scenario.run().recording["truth_road_friction"]
    assert driven.values[[0, -1]].tolist() == pytest.approx([1.0, 0.6], abs=1e-6)
