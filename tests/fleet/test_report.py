"""Page and document of a fleet: worst first, with its drives, and a ledger; damaged and empty results."""

import json
from importlib.resources import files

import jsonschema
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.cli import main
from tierod.fleet.report import document, text, worked_out
from tierod.fleet.report_page import render
from tierod.fleet.schema import findings, ledger
from tierod.fleet.trends import Design
from tierod.vehicles import load
from tierod_lab.fleet.virtual import SECONDS_PER_DAY, Ageing, FleetFile, Linear, drawn
from tierod_lab.fleet.writing import shipped_law, write_estimates

SCHEMA = json.loads(files("tierod.fleet").joinpath("fleet.schema.json").read_text(encoding="utf-8"))
RAMP = Ageing("ramp", Linear(0.02 / SECONDS_PER_DAY), 0.04, (60.0 * SECONDS_PER_DAY, 80.0 * SECONDS_PER_DAY))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_estimates(drawn(FleetFile("tests", 50, "2025-10-01", weeks=30, ageing=(RAMP,))), folder, shipped_law())
    rows = [{"recording_name": f"<b>{n}.mf4", "outcome": "failed", "reason": "it is damaged"} for n in range(2)]
    pq.write_table(pa.Table.from_pylist(rows, schema=ledger()), folder / "ledger" / "z.parquet")
    return folder


@pytest.fixture(scope="module")
def found(results):
    from tierod.fleet.report import report as of

    return of(results)


def sensor(vehicle, statuses, name="yaw_rate"):
    return [
        {
            "vehicle": vehicle,
            "monitor": "condition",
            "judged": name,
            "role": "sensor",
            "status": status,
            "kind": "offset",
        }
        for status in statuses
    ]


def made(rows):
    return pa.Table.from_pylist(rows, schema=findings())


def test_the_document_fits_its_schema_and_names_the_worst_first(found):
    content = json.loads(text(found))
    jsonschema.validate(content, SCHEMA)
    assert content["vehicles"] == 50
    assert content["recordings"] == {"failed": 2, "judged": 1500}
    changed = [reason for car in content["cars"] for reason in car["reasons"] if (reason["trend"] or {}).get("alarmed")]
    assert len(changed) == 2
    assert [car["rank"] for car in content["cars"]] == list(range(1, len(content["cars"]) + 1))
    best = changed[0]
    assert best["trend"]["change"]["kind"] == "ramp"
    assert best["trend"]["change"]["size"][0] == pytest.approx(0.02, rel=0.1)
    assert best["drives"][0]["start"] > best["drives"][1]["start"]
    assert "grease" in best["inspect"]
    assert content["not_judged"][0]["count"] == 2


def test_the_page_shows_it_in_one_small_file(found):
    page = render(found)
    assert len(page.encode()) < 2_000_000
    for car in found.cars[:3]:
        assert car.vehicle in page
    assert "per 100 days" in page
    assert "Drives that show it" in page
    assert "it is damaged" in page
    assert "<b>0.mf4" not in page
    assert 'src="http' not in page


def test_the_command_writes_both_and_says_what_it_found(results, tmp_path, capsys):
    assert main(["fleet", "report", str(results), "-o", str(tmp_path / "new" / "folder")]) == 1
    said = capsys.readouterr().out
    assert "of 50 cars to look at" in said
    assert (tmp_path / "new/folder/fleet.html").stat().st_size > 100_000
    assert main(["fleet", "report", str(results), "-o", str(tmp_path), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["schema"] == "tierod.fleet/2"


def test_a_prior_is_written_for_a_new_car(results, tmp_path, capsys):
    path = tmp_path / "new.toml"
    path.write_text(load("midsize-eps").path.read_text(encoding="utf-8"), encoding="utf-8")
    assert main(["fleet", "report", str(results), "-o", str(tmp_path), "--prior", str(path)]) == 1
    assert "nominal_friction is" in capsys.readouterr().out
    assert load(path)["nominal_friction"] != load("midsize-eps")["nominal_friction"]
    assert "fleet of 50 cars" in load(path).parameters["nominal_friction"].source
    for cohort, message in (("batch", "expected KIND=NAME"), ("batch=7", "no car of the fleet has batch '7'")):
        words = ["fleet", "report", str(results), "-o", str(tmp_path), "--prior", str(path), "--cohort", cohort]
        assert main(words) == 3
        assert message in capsys.readouterr().err


def test_empty_results_say_so():
    empty = worked_out(findings().empty_table(), ledger().empty_table(), Design())
    assert "There are no findings yet" in render(empty)
    jsonschema.validate(json.loads(text(empty)), SCHEMA)


def test_every_reason_stands_once_in_the_list_with_the_times_of_its_episode():
    def row(judged, status, **more):
        whole = {"vehicle": "car 7", "monitor": "condition", "judged": judged, "recording_name": "a.csv"}
        return {**whole, "status": status, **more}

    times = {"since_s": 100.0, "declared_s": 104.5, "end_s": 160.0}
    rows = [row("", "fault"), row("yaw_rate", "fault", **times), row("steering_wheel_angle", "fault")]
    rows += [{**row("", "suspect"), "monitor": "friction"}]
    found = worked_out(made(rows), ledger().empty_table(), Design())
    (car,) = found.cars
    subjects = [reason.text.partition(":")[0] for reason in car.reasons]
    assert sorted(subjects) == ["monitor friction", "steering_wheel_angle", "yaw_rate"]
    assert all(car.why.count(f"{subject}: ") == 1 for subject in subjects)
    assert car.inspect.count("look at these drives") == 1
    (drive,) = next(each for each in document(found)["cars"][0]["reasons"] if "yaw" in each["text"])["drives"]
    assert {name: drive[name] for name in times} == times
    page = render(found)
    assert all(f">{each}<" in page for each in ("1 min 40 s", "1 min 44.5 s", "2 min 40 s"))
