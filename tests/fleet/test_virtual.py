"""Virtual fleets: cars, seasons, ageing laws, measured errors, files."""

import dataclasses
import json

import numpy as np
import pyarrow.parquet as pq
import pytest

from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod_lab.fleet.estimates import error_law, estimates
from tierod_lab.fleet.virtual import (
    SECONDS_PER_DAY,
    YEAR,
    FleetFile,
    Group,
    Linear,
    Sudden,
    describes_fleet,
    drawn,
    load,
)
from tierod_lab.fleet.writing import PATTERN, fleet_file, recordings_of, shipped_law

TEXT = """
name = "small"
cars = 2
start = "2026-01-05"
weeks = 2
duration = "15 s"
[[groups]]
kind = "rack batch"
name = "2025-47"
share = 0.5
friction = "1 N*m"
[[ageing]]
name = "worn"
share = 0.5
law = {kind = "linear", rate = "0.01 N*m/d"}
begin = ["1 d", "2 d"]
"""


@pytest.fixture
def path(tmp_path):
    target = tmp_path / "small.toml"
    target.write_text(TEXT, encoding="utf-8")
    return target


def test_a_file_becomes_cars(path):
    cars = drawn(load(path))
    assert cars.day.shape == (2, 2)
    assert sorted(cars.labels["rack batch"]) == ["2025-47", "others"]
    assert sum(map(bool, cars.ageing)) == 1
    assert (np.diff(cars.day) > 0.0).all()
    assert (np.diff(cars.mileage) > 0.0).all()
    assert describes_fleet(path)
    assert not describes_fleet("mixed-drive-healthy")


def test_cars_have_the_frictions_that_the_file_gives():
    file = FleetFile("many", 4000, "2025-01-06", groups=(Group("batch", "odd", 0.25, 1.0),), per_metre=0.0)
    cars = drawn(file)
    odd = np.array(cars.labels["batch"]) == "odd"
    assert odd.sum() == 1000
    warm = cars.temperature - 288.15
    own = cars.friction - file.per_kelvin * warm
    assert np.ptp(own, axis=1).max() < 1e-9
    assert own[odd, 0].mean() - own[~odd, 0].mean() == pytest.approx(1.0, abs=0.03)
    assert own[~odd, 0].std() == pytest.approx(0.2, rel=0.05)
    of_year = cars.day[0] % YEAR
    assert cars.temperature[:, np.argmin(abs(of_year - 200.0))].mean() == pytest.approx(283.15 + 9.0, abs=0.5)
    assert cars.winter[0][of_year < 80.0].all()
    assert not cars.winter[0][(of_year > 100.0) & (of_year < 300.0)].any()


def test_the_same_seed_draws_the_same_cars_and_another_one_others():
    file = FleetFile("a", 5, "2026-01-05", weeks=3)
    np.testing.assert_array_equal(drawn(file).friction, drawn(file).friction)
    assert not np.allclose(drawn(file).friction, drawn(FleetFile("a", 5, "2026-01-05", weeks=3, seed=2)).friction)


def test_ageing_laws():
    day, begin = np.array([10.0, 20.0, 30.0]), np.array(15.0)
    np.testing.assert_allclose(Linear(0.1 / SECONDS_PER_DAY).added(day, begin), [0.0, 0.5, 1.5])
    np.testing.assert_allclose(Sudden(2.0).added(day, begin), [0.0, 2.0, 2.0])


def test_the_law_of_errors_is_found_again_in_drawn_estimates():
    file = FleetFile("law", 600, "2025-10-06", weeks=60, friction_deviation=0.5, wrong_share=0.0)
    law, cars = dataclasses.replace(shipped_law(), winter=0.05, winter_deviation=0.03), drawn(file)
    value, stated = estimates(cars, law, (3, 3))
    number = np.repeat(np.arange(600), cars.day.shape[1])
    found = error_law(number, cars.winter.ravel(), cars.friction.ravel(), value.ravel(), stated.ravel())
    assert found.drive_deviation == pytest.approx(law.drive_deviation, rel=0.02)
    assert found.stated == pytest.approx(law.stated, rel=0.01)
    assert found.winter == pytest.approx(0.05, abs=0.01)
    assert found.winter_deviation == pytest.approx(0.03, rel=0.15)
    assert found.offset == pytest.approx(law.offset, abs=0.1)


def test_the_fleet_file_names_every_car_and_recording(path, tmp_path):
    import re
    import tomllib

    cars = drawn(load(path))
    content = tomllib.loads(fleet_file(cars))
    assert set(content["vehicles"]) == set(cars.names)
    for task in recordings_of(cars, tmp_path):
        match = re.search(content["recordings"][0]["pattern"], task.path.as_posix())
        assert match is not None
        assert match["vehicle"] in cars.names
    assert content["recordings"][0]["pattern"] == PATTERN


def test_simulate_drives_a_fleet_and_goes_on_where_it_was(path, tmp_path, capsys):
    folder = tmp_path / "fleet"
    assert main(["simulate", str(path), "-o", str(folder), "--workers", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["drives"] == 4
    recordings = sorted(folder.glob("recordings/*/*.parquet"))
    assert len(recordings) == 4
    truth = pq.read_table(folder / "truth.parquet")
    assert len(truth) == 4
    before = [each.stat().st_mtime_ns for each in recordings]
    recordings[0].unlink()
    assert main(["simulate", str(path), "-o", str(folder), "--workers", "1"]) == 0
    assert [each.stat().st_mtime_ns for each in recordings[1:]] == before[1:]
    assert recordings[0].is_file()


def test_simulate_draws_estimates_that_the_report_reads(path, tmp_path, capsys):
    assert main(["simulate", str(path), "-o", str(tmp_path / "r"), "--estimates"]) == 0
    assert "estimate level" in capsys.readouterr().out
    from tierod.fleet.results import findings_of

    assert len(findings_of(tmp_path / "r")) == 4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('start = "2026-01-05"', 'start = "Monday"', "expected a day like"),
        ("share = 0.5\nfriction", "share = 1.5\nfriction", "expected 1 at the most"),
        ('begin = ["1 d", "2 d"]', 'begin = ["2 d", "1 d"]', "give the earlier time first"),
        ("weeks = 2", "week = 2", "'week' is not known here"),
        ('kind = "linear"', 'kind = "line"', "no kind is called"),
    ],
)
def test_slips_are_named(path, old, new, message):
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(ParameterError, match=message):
        load(path)
