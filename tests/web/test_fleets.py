"""A fleet for the page: worst first, filtered, one car with its drives."""

import time

import pytest

from tierod.core.errors import InputError
from tierod.web.fleets import Fleets, filtered, key_of, work_out
from tierod.web.site import Site, roots_of
from tierod_lab.fleet.virtual import SECONDS_PER_DAY, Ageing, FleetFile, Group, Linear, drawn
from tierod_lab.fleet.writing import shipped_law, write_estimates


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet") / "results"
    worn = Ageing("worn", Linear(0.02 / SECONDS_PER_DAY), 0.1, (30.0 * SECONDS_PER_DAY, 60.0 * SECONDS_PER_DAY))
    batch = Group("batch", "odd", 0.3, 0.5)
    file = FleetFile("f", cars=30, start="2024-01-08", weeks=40, groups=(batch,), ageing=(worn,))
    cars = drawn(file)
    write_estimates(cars, folder, shipped_law())
    return folder, {name for name, age in zip(cars.names, cars.ageing, strict=True) if age}


@pytest.fixture(scope="module")
def worked(results, tmp_path_factory):
    cache = tmp_path_factory.mktemp("cache")
    key = key_of(results[0])
    work_out(results[0], cache, key)
    found = Fleets(cache).loaded(key)
    assert found is not None
    return found


def test_worn_cars_come_first_and_every_car_has_a_row(worked, results):
    rows = worked["rows"]
    assert len(rows) == 30
    assert {row["vehicle"] for row in rows[: len(results[1])]} == results[1]
    assert [row["rank"] for row in rows] == list(range(1, 31))
    assert set(worked["bands"]["0"]) >= results[1]


def test_rows_are_filtered_and_sorted(worked, results):
    rows = worked["rows"]
    assert {row["vehicle"] for row in filtered(rows, state="any")} >= results[1]
    odd = filtered(rows, cohort="batch=odd")
    assert {row["cohort"]["batch"] for row in odd} == {"odd"}
    assert [row["vehicle"] for row in filtered(rows, search="CAR-01")] == ["car-01"]
    levels = [row["level"] for row in filtered(rows, sort="-level")]
    assert levels == sorted(levels, reverse=True)
    with pytest.raises(InputError, match="no column"):
        filtered(rows, sort="__class__")


def test_endpoints_give_the_fleet_once_it_is_worked_out(results, tmp_path):
    from tierod.web.app import application
    from tierod.web.guard import Trust
    from tierod.web.workbench import Workbench
    from web_client import TestClient

    site = Site((), roots_of([results[0]])[1], tmp_path / "cache", "midsize-eps")
    with Workbench(site) as bench, TestClient(application(bench, Trust(80)), base_url="http://localhost") as client:
        found = client.get("/api/fleets/results").json()
        until = time.monotonic() + 60.0
        while "job" in found and time.monotonic() < until:
            time.sleep(0.1)
            found = client.get("/api/fleets/results").json()
        assert found["vehicles"] == 30
        table = client.get("/api/fleets/results/cars", params={"count": 5}).json()
        assert (table["total"], len(table["rows"])) == (30, 5)
        car = client.get("/api/fleets/results/car", params={"vehicle": table["rows"][0]["vehicle"]}).json()
        assert len(car["drives"]) == 40
        assert car["bands"]["0"]["level"]
        assert client.get("/api/fleets/other").status_code == 404
