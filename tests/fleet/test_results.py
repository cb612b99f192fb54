"""The tables of a results folder: their versions, and reading them."""

import datetime as dt
import time

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from fleet.drives import Here, judged, written
from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Trace
from tierod.fleet import fleet_file, levels, schema
from tierod.fleet.fleet_file import Assigned
from tierod.fleet.places import fits
from tierod.fleet.results import findings_of, ledger_of

DAY = dt.datetime(2026, 11, 3, 8, tzinfo=dt.UTC)


def write(folder, path, table, rows, metadata=None):
    whole = getattr(schema, table)()
    made = pa.Table.from_pylist(rows, schema=whole.with_metadata(metadata or whole.metadata))
    (folder / path).parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(made, folder / path)


def test_findings_come_in_the_order_of_vehicle_and_time(tmp_path):
    write(tmp_path, "ledger/1.parquet", "ledger", [{"recording_name": "a"}])
    later = {"vehicle": "car 2", "start": DAY, "recording_name": "b", "span": 0, "cohort": [("batch", "7")]}
    write(tmp_path, "findings/month=2026-11/x.parquet", "findings", [later, later | {"vehicle": "car 1"}])
    write(tmp_path, "findings/month=2026-10/x.parquet", "findings", [later | {"start": DAY - dt.timedelta(days=30)}])
    found = findings_of(tmp_path)
    assert found.schema.equals(schema.findings())
    assert found["vehicle"].to_pylist() == ["car 1", "car 2", "car 2"]
    assert [start.month for start in found["start"].to_pylist()] == [11, 10, 11]
    assert found["cohort"].to_pylist()[0] == [("batch", "7")]
    assert findings_of(tmp_path, ["vehicle"]).column_names == ["vehicle"]


def test_the_last_row_of_a_recording_holds(tmp_path):
    rows = [{"recording_name": name, "outcome": outcome} for name, outcome in (("a", "failed"), ("b", "judged"))]
    write(tmp_path, "ledger/1.parquet", "ledger", rows)
    write(tmp_path, "ledger/2.parquet", "ledger", [{"recording_name": "a", "outcome": "judged"}])
    assert ledger_of(tmp_path)["outcome"].to_pylist() == ["judged", "judged"]
    assert ledger_of(str(tmp_path))["recording_name"].to_pylist() == ["a", "b"]


def test_the_word_of_an_estimate_in_results_of_version_1_is_its_status(tmp_path):
    write(tmp_path, "ledger/1.parquet", "ledger", [])
    old = pa.table({"vehicle": ["a", "b"], "status": ["healthy", "fault"], "word": ["estimated", None]})
    (tmp_path / "findings").mkdir()
    pq.write_table(old.replace_schema_metadata({schema.NAME: b"findings/1"}), tmp_path / "findings/x.parquet")
    assert findings_of(tmp_path, ["vehicle", "status"])["status"].to_pylist() == ["estimated", "fault"]


def test_what_is_no_results_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no results"):
        findings_of(tmp_path)
    write(tmp_path, "ledger/1.parquet", "ledger", [], {schema.NAME: b"ledger/99"})
    with pytest.raises(InputError, match=r"version 2 or earlier \(99\)"):
        ledger_of(tmp_path)
    (tmp_path / "ledger/1.parquet").write_bytes(b"PAR1 torn")
    with pytest.raises(InputError, match=r"damaged .*delete it"):
        ledger_of(tmp_path)


def trace(count, width=0.5, name="torque"):
    time = width * np.arange(count)
    values = np.sin(0.01 * time)
    values[count // 2] = 7.0
    return Trace(name, "N*m", time, values - 1.0, values + 1.0, values)


def kept(folder, traces):
    path = folder / levels.path_of("ab12")
    path.parent.mkdir(parents=True)
    path.write_bytes(levels.content_of({"friction": {each.name: each for each in traces}}))
    return path


def test_a_zoom_reads_the_coarsest_level_that_is_fine_enough(tmp_path, monkeypatch):
    path = kept(tmp_path, [trace(40000), trace(40000, name="angle")])
    whole = levels.zoom(tmp_path, "ab12", "torque", points=60)
    assert (whole["level"][0].as_py(), len(whole)) == (1, 79)
    read, original = [], pq.ParquetFile.read_row_groups

    def counted(file, groups):
        read.extend(groups)
        return original(file, groups)

    monkeypatch.setattr(pq.ParquetFile, "read_row_groups", counted)
    part = levels.zoom(tmp_path, "ab12", "torque", 10000.0, 10060.0, points=50)
    assert (part["level"][0].as_py(), len(part), part["time_s"][0].as_py()) == (5, 60, 10000.0)
    assert max(part["upper"].to_pylist()) == 8.0
    assert len(read) < pq.ParquetFile(path).metadata.num_row_groups / 2


def test_what_is_not_there_is_named(tmp_path):
    kept(tmp_path, [trace(100)])
    with pytest.raises(InputError, match="no estimate 'angle'"):
        levels.zoom(tmp_path, "ab12", "angle")
    with pytest.raises(InputError, match="without --no-levels"):
        levels.zoom(tmp_path, "cd34", "angle")


def test_a_run_keeps_the_estimates_of_its_monitors(tmp_path):
    written(tmp_path / "a.parquet")
    judged(tmp_path / "a.parquet", tmp_path / "results")
    (key,) = findings_of(tmp_path / "results")["key"].to_pylist()
    found = levels.zoom(tmp_path / "results", key, "enabled")
    assert found["monitor"][0].as_py() == "friction"
    assert 30 <= len(found) <= 41
    judged(tmp_path / "a.parquet", tmp_path / "without", with_levels=False)
    assert not (tmp_path / "without/levels").exists()


TEXT = """
[[recordings]]
pattern = 'drives/(?P<vehicle>[^/]+)/(?P<climate>cold|warm)-(?P<mileage>\\d+)-(?P<start>[-T0-9]+)[.]parquet'
parameters = "cars/usual.toml"
cohort = {supplier = "A", batch = "none"}
mileage_unit = "mile"

[[recordings]]
files = "*.mf4"
metadata = "vin"
cohort_metadata = ["plant"]
mileage_metadata = "odometer"

[vehicles.car-17]
parameters = "midsize-eps"
cohort = {batch = "B7"}
mileage = "5 km"
"""


@pytest.fixture
def assigned_by(tmp_path):
    (tmp_path / "assigned_by.toml").write_text(TEXT)
    return fleet_file.load(tmp_path / "assigned_by.toml")


def test_groups_of_a_pattern_name_vehicle_cohort_mileage_and_start(assigned_by, tmp_path):
    found = assigned_by.assigned("s3://bucket/drives/car-4/cold-1000-20261103T080000.parquet", {})
    cohort = {"batch": "none", "climate": "cold", "supplier": "A"}
    assert found == Assigned("car-4", str(tmp_path / "cars/usual.toml"), cohort, 1609344.0, 1793692800.0)


def test_metadata_of_the_recording_name_it(assigned_by):
    assert assigned_by.entry("x/y.mf4").looks_inside
    found = assigned_by.assigned("x/y.mf4", {"vin": "car-17", "plant": "north", "odometer": "12"})
    assert found == Assigned("car-17", "midsize-eps", {"batch": "B7", "plant": "north"}, 12000.0, None)
    with pytest.raises(ParameterError, match="hold no text 'vin'; did you mean 'vim'"):
        assigned_by.assigned("x/y.mf4", {"vim": "car-17"})
    with pytest.raises(ParameterError, match="mileage is 'far', which is not a number"):
        assigned_by.assigned("x/y.mf4", {"vin": "car-17", "plant": "north", "odometer": "far"})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "'recordings' is missing"),
        ("recordings = []", r"no \[\[recordings\]\]"),
        ("[[recordings]]\nfiles = '*'\n", "line 1: an entry of 'recordings' names the vehicle in one way"),
        ("[[recordings]]\nvehicle = 'a'\nmetadata = 'vin'\n", "in one way"),
        ("[[recordings]]\npattern = '(('\nvehicle = 'a'\n", "is not a regular expression"),
        ("[[recordings]]\npattern = '(?=a)(?P<vehicle>.)'\n", "not a regular expression of RE2 .* without look-around"),
        ("[[recordings]]\npattern = '(?P<vehicle>.)/\\1'\n", "without look-around .*, back-references"),
        ("[[recordings]]\nfiles = '[z-a].mf4'\nvehicle = 'a'\n", "'\\[z-a\\].mf4' has a range that is none"),
        ("[[recordings]]\nvehicel = 'a'\n", "line 2: 'vehicel' is not known here; did you mean 'vehicle'"),
        ("[[recordings]]\nvehicle = 'a'\nmileage_unit = 'kg'\n", "kg"),
    ],
)
def test_a_slip_is_named(tmp_path, text, words):
    (tmp_path / "assigned_by.toml").write_text(text)
    with pytest.raises(ParameterError, match=words):
        fleet_file.load(tmp_path / "assigned_by.toml")


@pytest.mark.parametrize(
    ("name", "pattern", "right"),
    [
        ("a/b/c.mf4", "a/**/*.mf4", True),
        ("a/c.mf4", "a/**/*.mf4", True),
        ("a/b/c.mf4", "a/*.mf4", False),
        ("/x/a/c.mf4", "a/?.mf4", True),
        ("/x/ba/c.mf4", "a/?.mf4", False),
        ("a/c1.mf4", "c[0-9].mf4", True),
        ("a/c1.mf4", "c[!0-9].mf4", False),
        ("a/c+.mf4", "c+.mf4", True),
    ],
)
def test_patterns(name, pattern, right):
    assert fits(name, pattern) is right


@pytest.mark.parametrize("pattern", [r"(?P<vehicle>(a+)+)$", r"(?P<vehicle>(a|aa)+)$", r"(.*a){20}(?P<vehicle>b)"])
def test_any_pattern_is_matched_in_bounded_time(tmp_path, pattern):
    (tmp_path / "assigned_by.toml").write_text(f"[[recordings]]\npattern = '{pattern}'\n")
    assigned_by = fleet_file.load(tmp_path / "assigned_by.toml")
    begin = time.process_time()
    with pytest.raises(ParameterError, match="no entry"):
        assigned_by.entry(200 * "a" + "X.parquet")
    assert not fits("/".join(60 * "a"), 12 * "**/" + "b")
    assert time.process_time() - begin < 1.0


def test_a_column_and_metadata_name_the_vehicle_of_a_recording(tmp_path):
    path = written(tmp_path / "a.parquet", vin="car-9")
    table = pq.read_table(path)
    table = table.append_column("plate", pa.array(["S-TR 17"] * len(table)))
    pq.write_table(table, tmp_path / "b.parquet")
    (tmp_path / "assigned_by.toml").write_text("""
[[recordings]]
files = "a.parquet"
metadata = "vin"

[[recordings]]
column = "plate"
parameters = "midsize-eps"
""")
    judged(tmp_path / "*.parquet", tmp_path / "results", fleet_file.load(tmp_path / "assigned_by.toml"))
    assert findings_of(tmp_path / "results")["vehicle"].to_pylist() == ["S-TR 17", "car-9"]
    rows = ledger_of(tmp_path / "results").to_pylist()
    assert [row["vehicle"] for row in rows] == ["car-9", "S-TR 17"]
    workers = Here()
    judged(
        tmp_path / "*.parquet", tmp_path / "results", fleet_file.load(tmp_path / "assigned_by.toml"), workers=workers
    )
    assert str(tmp_path / "a.parquet") not in workers.tasks
