"""The fleet file: from the name and the metadata of a recording to its vehicle, cohort and mileage."""

import time

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from fleet.drives import Here, judged, written
from tierod.core.errors import ParameterError
from tierod.fleet import fleet_file
from tierod.fleet.fleet_file import Assigned
from tierod.fleet.places import fits
from tierod.fleet.results import findings_of, ledger_of

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
def fleet(tmp_path):
    (tmp_path / "fleet.toml").write_text(TEXT)
    return fleet_file.load(tmp_path / "fleet.toml")


def test_groups_of_a_pattern_name_vehicle_cohort_mileage_and_start(fleet, tmp_path):
    found = fleet.assigned("s3://bucket/drives/car-4/cold-1000-20261103T080000.parquet", {})
    cohort = {"batch": "none", "climate": "cold", "supplier": "A"}
    assert found == Assigned("car-4", str(tmp_path / "cars/usual.toml"), cohort, 1609344.0, 1793692800.0)


def test_a_table_of_a_vehicle_goes_before_its_entry(fleet):
    found = fleet.assigned("drives/car-17/warm-1-20261103.parquet", {})
    assert (found.parameters, found.cohort["batch"], found.cohort["supplier"]) == ("midsize-eps", "B7", "A")


def test_metadata_of_the_recording_name_it(fleet):
    assert fleet.entry("x/y.mf4").looks_inside
    found = fleet.assigned("x/y.mf4", {"vin": "car-17", "plant": "north", "odometer": "12"})
    assert found == Assigned("car-17", "midsize-eps", {"batch": "B7", "plant": "north"}, 12000.0, None)
    with pytest.raises(ParameterError, match="hold no text 'vin'; did you mean 'vim'"):
        fleet.assigned("x/y.mf4", {"vim": "car-17"})
    with pytest.raises(ParameterError, match="mileage is 'far', which is not a number"):
        fleet.assigned("x/y.mf4", {"vin": "car-17", "plant": "north", "odometer": "far"})


def test_what_fits_no_entry_is_refused(fleet):
    with pytest.raises(ParameterError, match="no entry of 'recordings' in .* fits it"):
        fleet.assigned("elsewhere/a.parquet", {})


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
    (tmp_path / "fleet.toml").write_text(text)
    with pytest.raises(ParameterError, match=words):
        fleet_file.load(tmp_path / "fleet.toml")


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
    (tmp_path / "fleet.toml").write_text(f"[[recordings]]\npattern = '{pattern}'\n")
    fleet = fleet_file.load(tmp_path / "fleet.toml")
    begin = time.process_time()
    with pytest.raises(ParameterError, match="no entry"):
        fleet.entry(200 * "a" + "X.parquet")
    assert not fits("/".join(60 * "a"), 12 * "**/" + "b")
    assert time.process_time() - begin < 1.0


def test_a_column_and_metadata_name_the_vehicle_of_a_recording(tmp_path):
    path = written(tmp_path / "a.parquet", vin="car-9")
    table = pq.read_table(path)
    table = table.append_column("plate", pa.array(["S-TR 17"] * len(table)))
    pq.write_table(table, tmp_path / "b.parquet")
    (tmp_path / "fleet.toml").write_text("""
[[recordings]]
files = "a.parquet"
metadata = "vin"

[[recordings]]
column = "plate"
parameters = "midsize-eps"
""")
    judged(tmp_path / "*.parquet", tmp_path / "results", fleet_file.load(tmp_path / "fleet.toml"))
    assert findings_of(tmp_path / "results")["vehicle"].to_pylist() == ["S-TR 17", "car-9"]
    rows = ledger_of(tmp_path / "results").to_pylist()
    assert [row["vehicle"] for row in rows] == ["car-9", "S-TR 17"]
    workers = Here()
    judged(tmp_path / "*.parquet", tmp_path / "results", fleet_file.load(tmp_path / "fleet.toml"), workers=workers)
    assert str(tmp_path / "a.parquet") not in workers.tasks
