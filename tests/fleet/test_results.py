"""The tables of a results folder: their versions, and reading them."""

import datetime as dt

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tierod.core.errors import InputError
from tierod.fleet import schema
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


def test_columns_of_a_later_tierod_are_left_out_and_missing_ones_are_null(tmp_path):
    write(tmp_path, "ledger/1.parquet", "ledger", [])
    short = pa.table({"vehicle": ["car 1"], "colour": ["red"]})
    (tmp_path / "findings").mkdir()
    pq.write_table(short.replace_schema_metadata({schema.NAME: b"findings/1"}), tmp_path / "findings/x.parquet")
    found = findings_of(tmp_path)
    assert found.schema.equals(schema.findings())
    assert found["start"].to_pylist() == [None]


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
