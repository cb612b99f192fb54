"""Trends, cohorts and priors over the findings of a small virtual fleet at estimate level."""

import dataclasses
import datetime as dt
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
from tierod_lab.fleet.estimates import error_law, estimates, findings_table
from tierod_lab.fleet.virtual import (
    SECONDS_PER_DAY,
    YEAR,
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


def test_an_unknown_cohort_or_quantity_is_refused(found, tmp_path):
    with pytest.raises(ParameterError, match="no car of the fleet has rack batch 'none'; known are odd, others"):
        expected_of(found.cohorts.cohorts, found.series, {"rack batch": "none"})
    expected = expected_of(found.cohorts.cohorts, found.series, {})
    other = dataclasses.replace(found.series, watched=found.series.watched._replace(quantity="lash"))
    with pytest.raises(ParameterError, match="no parameter of a vehicle file"):
        write_prior(tmp_path / "car.toml", other, expected)


def test_undated_and_future_drives_are_left_out_and_named(fleet):
    table = fleet[1].slice(0, 80)
    start = table["start"].to_pylist()
    start[3], start[5] = None, dt.datetime(2099, 1, 1, tzinfo=dt.UTC)
    changed = table.set_column(
        table.schema.get_field_index("start"), "start", pa.array(start, pa.timestamp("us", "UTC"))
    )
    (one, *_), remarks = series_of(changed, 30_000.0)
    assert one.drives.present.sum() == 78
    assert [remark.partition(" ")[0] for remark in remarks] == ["1", "1"]
    assert "no date" in remarks[0]
    assert "future" in remarks[1]


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


def test_simulate_draws_estimates_that_the_report_reads(fleet_path, tmp_path, capsys):
    assert main(["simulate", str(fleet_path), "-o", str(tmp_path / "r"), "--estimates"]) == 0
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
def test_slips_are_named(fleet_path, old, new, message):
    fleet_path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(ParameterError, match=message):
        load_fleet(fleet_path)
