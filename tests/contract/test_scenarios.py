"""Every scenario and virtual car that is shipped can be driven, and is read back."""

import json
from collections import Counter

import numpy as np
import pytest

from tierod.cli import main
from tierod.io.readers import read
from tierod_lab.ground import courses, scenarios
from tierod_lab.ground.cars import catalogue
from tierod_lab.ground.run import run


@pytest.mark.parametrize("name", scenarios.shipped())
def test_every_shipped_scenario_can_be_driven(name, tmp_path, capsys):
    assert main(["simulate", name, "-o", str(tmp_path / "drive.parquet"), "--seconds", "1.5", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    recording = read(tmp_path / "drive.parquet")
    assert recording.span[1] == pytest.approx(1.5, abs=0.02)
    assert set(result["measured_channels"] + result["truth_channels"]) == set(recording.names)
    assert all(np.isfinite(channel.values).any() for channel in recording.channels.values())


@pytest.mark.parametrize("name", scenarios.shipped())
def test_every_shipped_scenario_is_called_like_its_file_and_reported_in_a_sentence(name):
    scenario = scenarios.load(name)
    assert scenario.name == name
    assert scenario.description[0].isupper()
    assert scenario.description.endswith(".")
    assert len(scenario.description) < 110
    assert scenario.duration <= 900.0


@pytest.mark.parametrize("name", catalogue.shipped())
def test_every_shipped_car_can_be_driven(name):
    car = catalogue.load(name).block
    course = courses.load("mixed" if hasattr(car, "chassis") else "bench-sweep")
    outcome = run(car, course, 2.0)
    assert outcome.diverged_at is None
    assert all(np.isfinite(channel.values).all() for channel in outcome.recording.channels.values())


def test_the_shipped_scenarios_show_many_cars_courses_and_faults():
    found = [scenarios.load(name) for name in scenarios.shipped()]
    assert len(found) >= 10
    assert len({scenario.course.name for scenario in found}) >= 10
    assert len({scenario.car_name for scenario in found}) >= 8
    assert sum(bool(scenario.faults) for scenario in found) >= 4


def test_no_name_means_two_things():
    names = Counter([*scenarios.shipped(), *catalogue.shipped(), *courses.shipped()])
    assert not [name for name, count in names.items() if count > 1]
