"""Trends, cohorts and priors over the findings of a small virtual fleet at estimate level."""

import dataclasses
import datetime as dt

import numpy as np
import pyarrow as pa
import pytest

from tierod.core.errors import ParameterError
from tierod.fleet.series import series_of
from tierod.fleet.statistics import expected_of, write_prior
from tierod.fleet.trends import Design, trends
from tierod.vehicles import load
from tierod_lab.fleet.estimates import estimates, findings_table, series
from tierod_lab.fleet.virtual import SECONDS_PER_DAY, Ageing, FleetFile, Group, Linear, Sudden, drawn
from tierod_lab.fleet.writing import shipped_law

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


def test_the_table_and_the_short_way_give_the_same_series(fleet):
    cars, table = fleet
    ours, whole = series(cars, *estimates(cars, shipped_law(), (1, 1))), series_of(table)[0][0]
    assert ours.vehicles == whole.vehicles
    assert ours.labels == whole.labels
    for name in ("day", "estimate", "deviation", "regressors"):
        np.testing.assert_allclose(getattr(ours.drives, name), getattr(whole.drives, name), atol=1e-9)
    np.testing.assert_allclose(ours.limit, whole.limit)


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


def test_time_left_has_its_interval_in_order(found):
    early, likely, late = found.left.T
    assert (early <= likely).all()
    assert (likely <= late).all()
    assert (found.left[np.isfinite(found.alarmed), 0] < 3652.5).all()


def test_the_band_holds_the_level_of_now(found):
    day, level, deviation = found.band(3)
    assert level[-1] == pytest.approx(found.level[3, 0], abs=1e-9)
    assert deviation[-1] == pytest.approx(found.level[3, 1], abs=1e-9)
    assert (np.diff(day) > 0.0).all()
    assert np.abs(np.diff(level)).max() < 0.1


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


def test_no_findings_give_no_series(fleet):
    assert series_of(fleet[1].slice(0, 0)) == ([], [])
