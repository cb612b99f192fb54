"""Trends, cohorts and priors over the findings of a small virtual fleet at estimate level."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.cli import main
from tierod.core.errors import ParameterError
from tierod.fleet.series import series_of
from tierod.fleet.statistics import expected_of, write_prior
from tierod.fleet.trends import Design, trends
from tierod.vehicles import load
from tierod_lab.fleet.estimates import estimates, findings_table
from tierod_lab.fleet.virtual import (
    SECONDS_PER_DAY,
    Ageing,
    FleetFile,
    Group,
    Linear,
    Sudden,
    describes_fleet,
    drawn,
)
from tierod_lab.fleet.virtual import load as load_fleet
from tierod_lab.fleet.writing import PATTERN, fleet_file, recordings_of, shipped_law

FILE = FleetFile(
    "tests",
    200,
    "2025-10-01",
    weeks=40,
    groups=(Group("rack batch", "odd", 0.1, 1.0), Group("climate", "north", 0.4, warmer=-6.0)),
    ageing=(
        Ageing("ramp", Linear(0.01 / SECONDS_PER_DAY), 0.03, (80.0 * SECONDS_PER_DAY, 120.0 * SECONDS_PER_DAY)),
        Ageing("step", Sudden(1.5), 0.02, (80.0 * SECONDS_PER_DAY, 120.0 * SECONDS_PER_DAY)),
    ),
)


@pytest.fixture(scope="module")
def fleet():
    cars = drawn(FILE)
    return cars, findings_table(cars, *estimates(cars, shipped_law(), (1, 1)))


@pytest.fixture(scope="module")
def found(fleet):
    return trends(series_of(fleet[1])[0][0], Design())


def test_changed_cars_are_found_and_no_others(fleet, found):
    changed = np.isfinite(fleet[0].begin)
    np.testing.assert_array_equal(np.isfinite(found.alarmed), changed)
    np.testing.assert_array_equal(found.listed, changed)
    late = (found.alarmed - fleet[0].begin)[changed]
    assert late.min() > 0.0
    assert np.median(late) < 35.0
    assert (found.earliest[changed] <= fleet[0].begin[changed] + 7.0).all()


def test_kind_size_and_level_are_right(fleet, found):
    names = np.array(fleet[0].ageing)
    steps, ramps = names == "step", names == "ramp"
    assert (found.kind[steps] == 0).all()
    assert found.size[steps, 0] == pytest.approx(1.5, rel=0.25)
    assert found.size[ramps, 0] == pytest.approx(0.01, rel=0.25)
    assert (found.slope[ramps, 0] > 0.005).all()
    # levels carry the offset of the car's sensors; truth is at the temperature of the drive
    last = np.array([fleet[0].friction[car, -1] for car in np.flatnonzero(ramps)])
    assert np.abs(found.level[ramps, 0] - last).max() < 1.5


def test_the_levels_of_stepped_cars_step_and_no_others_do(fleet, found):
    steps = np.array(fleet[0].ageing) == "step"
    np.testing.assert_array_equal(found.steps.any(axis=1), steps)
    for car in np.flatnonzero(steps):
        assert 0.0 <= found.stepped(car) - fleet[0].begin[car] < 14.0
        day, level, _ = found.band(car)
        (at,) = np.flatnonzero(np.diff(day) == 0.0)
        assert level[at + 1] - level[at] == pytest.approx(1.5, abs=0.3)


def test_scatter_and_temperature_are_learnt(found):
    law = shipped_law()
    scatter = found.learnt.scatter
    assert np.hypot(scatter.scatter, scatter.scale * law.stated) == pytest.approx(law.drive_deviation, rel=0.15)
    assert scatter.effects[0] == pytest.approx(FILE.per_kelvin, rel=0.2)


def test_the_odd_batch_is_named_with_its_odds(found):
    (odd,) = found.cohorts.differing
    assert (odd.kind, odd.name, odd.cars) == ("rack batch", "odd", 20)
    assert odd.effect == pytest.approx(1.0, abs=0.3)
    assert odd.log_odds > 10.0


def test_a_new_car_starts_from_its_cohort(found, tmp_path):
    path = tmp_path / "new.toml"
    path.write_text(load("midsize-eps").path.read_text(encoding="utf-8"), encoding="utf-8")
    expected = expected_of(found.cohorts.cohorts, found.series, {"rack batch": "odd"})
    usual = expected_of(found.cohorts.cohorts, found.series, {})
    assert expected.value - usual.value == pytest.approx(found.cohorts.differing[0].effect)
    assert expected.standard_deviation > usual.standard_deviation
    write_prior(path, found.series, expected)
    parameter = load(path).parameters["nominal_friction"]
    assert parameter.value == pytest.approx(expected.value, rel=1e-6)
    assert parameter.standard_deviation == pytest.approx(expected.standard_deviation, rel=1e-2)
    assert "rack batch odd" in parameter.source
    assert load(path)["mass"] == load("midsize-eps")["mass"]


@pytest.mark.parametrize("cars", [1, 2, 5])
def test_few_cars_with_few_drives_give_remarks_and_no_alarm(fleet, cars):
    table = fleet[1].slice(0, 40 * cars).filter(pa.array([row % 40 < 4 for row in range(40 * cars)]))
    found = trends(series_of(table)[0][0], Design())
    assert not np.isfinite(found.alarmed).any()
    assert not found.listed.any()
    assert any("scatter" in remark for remark in found.learnt.remarks)
    assert np.isfinite(found.level).all()


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
def fleet_path(tmp_path):
    target = tmp_path / "small.toml"
    target.write_text(TEXT, encoding="utf-8")
    return target


def test_a_file_becomes_cars(fleet_path):
    cars = drawn(load_fleet(fleet_path))
    assert cars.day.shape == (2, 2)
    assert sorted(cars.labels["rack batch"]) == ["2025-47", "others"]
    assert sum(map(bool, cars.ageing)) == 1
    assert (np.diff(cars.day) > 0.0).all()
    assert (np.diff(cars.mileage) > 0.0).all()
    assert describes_fleet(fleet_path)
    assert not describes_fleet("mixed-drive-healthy")


def test_the_fleet_file_names_every_car_and_recording(fleet_path, tmp_path):
    import re
    import tomllib

    cars = drawn(load_fleet(fleet_path))
    content = tomllib.loads(fleet_file(cars))
    assert set(content["vehicles"]) == set(cars.names)
    for task in recordings_of(cars, tmp_path):
        match = re.search(content["recordings"][0]["pattern"], task.path.as_posix())
        assert match is not None
        assert match["vehicle"] in cars.names
    assert content["recordings"][0]["pattern"] == PATTERN


def test_simulate_drives_a_fleet_and_goes_on_where_it_was(fleet_path, tmp_path, capsys):
    folder = tmp_path / "fleet"
    assert main(["simulate", str(fleet_path), "-o", str(folder), "--workers", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["drives"] == 4
    recordings = sorted(folder.glob("recordings/*/*.parquet"))
    assert len(recordings) == 4
    truth = pq.read_table(folder / "truth.parquet")
    assert len(truth) == 4
    before = [each.stat().st_mtime_ns for each in recordings]
    recordings[0].unlink()
    assert main(["simulate", str(fleet_path), "-o", str(folder), "--workers", "1"]) == 0
    assert [each.stat().st_mtime_ns for each in recordings[1:]] == before[1:]
    assert recordings[0].is_file()


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
def test_slips_are_named(fleet_path, old, new, message):
    fleet_path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(ParameterError, match=message):
        load_fleet(fleet_path)
